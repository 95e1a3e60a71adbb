"""What a solve found, and the folder that it leaves."""
