"""Describes the extension collided._native to cffi: the functions of collided.h and collided_check.h, as they stand there, and
native.c's.

setup.py builds it with setuptools. CMake has the C source written by `build_native.py HEADER CHECK_HEADER OUTPUT`, and compiles it with
its own flags. Either fails where header and library differ: nothing is declared twice."""

import os
import re
import shlex
import subprocess
import sys

from cffi import FFI

HERE = os.path.dirname(os.path.abspath(__file__))


def declarations(path):
    """Of a header, what a C compiler declares: without the lines of the preprocessor, and what C++ alone sees."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    text = re.sub(r"#ifdef __cplusplus\n.*?#endif\n", "", text, flags=re.S)
    return re.sub(r"^\s*#.*\n", "", text, flags=re.M)


def describe(header, check_header, **options):
    """The extension, for that collided.h and collided_check.h."""
    ffi = FFI()
    ffi.cdef(declarations(header))
    ffi.cdef(declarations(check_header))
    ffi.cdef(declarations(os.path.join(HERE, "native.h")))
    ffi.set_source("collided._native", '#include "native.h"\n#include "collided_check.h"', py_limited_api=True, **options)
    return ffi


def installed():
    """For setup.py: COLLIDED_HEADER and COLLIDED_LIBRARY_DIR (folders, a colon between two), or what pkg-config knows, or the system's own folders."""
    def words(what):
        try:
            done = subprocess.run(["pkg-config", what, "collided"], capture_output=True, text=True, check=True)
            return [word[2:] for word in shlex.split(done.stdout)]
        except (OSError, subprocess.CalledProcessError):
            return []

    header, library = os.environ.get("COLLIDED_HEADER"), os.environ.get("COLLIDED_LIBRARY_DIR")
    folders = [os.path.dirname(header)] if header else words("--cflags-only-I") + ["/usr/local/include", "/usr/include"]
    found = [folder for folder in folders if os.path.exists(os.path.join(folder, "collided.h"))]
    if not found:
        raise SystemExit("collided.h is not found: install libcollided-dev, or name it in COLLIDED_HEADER")
    kernel = [folder for folder in (found[0], os.path.join(found[0], "check")) if os.path.exists(os.path.join(folder, "collided_check.h"))]
    if not kernel:
        raise SystemExit("collided_check.h is not found beside collided.h: install libcollided-dev")
    return describe(os.path.join(found[0], "collided.h"), os.path.join(kernel[0], "collided_check.h"), sources=["native.c"],
                    libraries=["collided", "collided_check", "m"], include_dirs=[found[0], kernel[0], HERE],
                    library_dirs=library.split(":") if library else words("--libs-only-L"))


if __name__ == "__main__":
    describe(sys.argv[1], sys.argv[2]).emit_c_code(sys.argv[3])
else:
    ffibuilder = installed()
