"""What every DXF file is written with."""

from __future__ import annotations

import io
import re
from typing import Any

from inverse.fabricate.extras import needed

_DATE = re.compile(r" @ \d{4}-\d\d-\d\dT\S+")  # behind the version of ezdxf, where no option leaves it out


def content_of(document: Any) -> bytes:
    """The content of a DXF file; the same drawing gives the same bytes, without date and ids by chance.

    Args:
        document: of ezdxf.
    """
    ezdxf: Any = needed("ezdxf")
    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    stream = io.StringIO()
    try:
        document.write(stream)
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before
    return _DATE.sub("", stream.getvalue()).encode(document.output_encoding)
