// What libwebsockets 4.1 keeps at the end of a context is not ours to free: settings of TLS, made by libssl and
// libcrypto.
extern "C" const char* __lsan_default_suppressions();  // NOLINT(bugprone-reserved-identifier): the sanitizer's name
extern "C" const char* __lsan_default_suppressions() { return "leak:libwebsockets\nleak:libssl\nleak:libcrypto\n"; }
