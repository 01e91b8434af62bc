// Preloaded, it makes libclips.so look like another version.
void WriteString(void* environment, const char* logical_name, const char* text);
void PrintBanner(void* environment) { WriteString(environment, "stdout", "         CLIPS (6.41 1/1/23)\n"); }
