// For AddressSanitizer: Mesa 22.3 never frees the buffer that OSMesaMakeCurrent makes for a context (480 bytes).
extern "C" {
[[gnu::weak]] const char* __asan_default_options();  // a program may have its own
const char* __lsan_default_suppressions();
}
const char* __asan_default_options() { return "print_suppressions=0"; }
const char* __lsan_default_suppressions() { return "leak:libOSMesa.so"; }
