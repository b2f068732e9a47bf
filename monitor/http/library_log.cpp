#include "monitor/http/library_log.hpp"

#include <libwebsockets.h>

namespace sinew::monitor {

void keep_library_errors() {
  lws_set_log_level(LLL_ERR, [](int level, const char* line) {
    if (!(level & LLL_ERR)) return;
    std::string& text = last_error();
    text = line;
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  });
}

std::string& last_error() {
  static thread_local std::string text;
  return text;
}

}  // namespace sinew::monitor
