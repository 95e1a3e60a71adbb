"""Functions of users: brought in, registered by name, and called by it."""
