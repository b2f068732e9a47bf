#include "monitor/http/message.hpp"

namespace sinew::monitor {

Bytes bytes_of(std::string_view text) {
  const auto* const data = reinterpret_cast<const std::byte*>(text.data());
  return std::make_shared<const std::vector<std::byte>>(data, data + text.size());
}

Response plain(int status, std::string_view why) {
  Response r;
  r.status = status, r.media_type = "text/plain; charset=utf-8", r.body = bytes_of(std::string(why) + "\n");
  return r;
}

const std::string* Request::argument(std::string_view name) const {
  const std::string* found = nullptr;
  for (const auto& [key, value] : query)
    if (key == name) found = &value;
  return found;
}

}  // namespace sinew::monitor
