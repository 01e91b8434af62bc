# Makes `stub` of the stub `raw` that nanobind wrote: cmake -D raw=FILE -D stub=FILE -P stub.cmake
file(READ "${raw}" text)
string(REPLACE "-> object:" "-> Any:" text "${text}")
file(WRITE "${stub}" "from typing import Any\n\n__version__: str\n\n${text}")
