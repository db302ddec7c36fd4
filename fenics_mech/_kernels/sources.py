"""What the kernels are made from, by which a library that is older is found out."""

from hashlib import sha256
from pathlib import Path


def fingerprint() -> str:
    """Give a hash of the sources that stand beside this file."""
    here = Path(__file__).parent
    files = [here / "build.py", *sorted(here.glob("*.hpp"))]
    return sha256(b"".join(file.read_bytes() for file in files)).hexdigest()
