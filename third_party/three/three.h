#pragma once

/// three.js as a classic script, compressed with gzip, in base64.
extern "C" const char* three_script();
