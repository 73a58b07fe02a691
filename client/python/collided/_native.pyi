"""The extension that build_native.py describes: cffi's handles on collided.h and native.h."""

from typing import Any

ffi: Any
lib: Any
