# SPDX-License-Identifier: Apache-2.0
"""Reader of Soak calibration files (version 1), written from docs/blob-format.md alone.

It shares no code with the writer or the runtime, so an agreement between them is evidence for the specification.
Everything is computed in double precision from the float32 numbers of the file, at the temperature rounded to float32.
"""

from .calibration import Calibration, SensorFlag
from .file import BlobError, crc32c, read_sections

__all__ = ["BlobError", "Calibration", "SensorFlag", "crc32c", "read_sections"]
