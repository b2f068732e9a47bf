#include "monitor/http/head.hpp"

#include <libwebsockets.h>

#include <array>
#include <iterator>
#include <utility>

#include "monitor/http/path.hpp"

namespace sinew::monitor {

std::string header_of(lws* wsi, int token) {
  const auto index = static_cast<lws_token_indexes>(token);
  const int length = lws_hdr_total_length(wsi, index);
  if (length <= 0) return {};
  std::string text(static_cast<std::size_t>(length) + 1, '\0');
  const int copied = lws_hdr_copy(wsi, text.data(), static_cast<int>(text.size()), index);
  text.resize(copied > 0 ? static_cast<std::size_t>(copied) : 0);
  return text;
}

std::string custom_header(lws* wsi, std::string_view name) {
  const int size = static_cast<int>(name.size());
  const int length = lws_hdr_custom_length(wsi, name.data(), size);
  if (length <= 0) return {};
  std::string text(static_cast<std::size_t>(length) + 1, '\0');
  const int copied = lws_hdr_custom_copy(wsi, text.data(), static_cast<int>(text.size()), name.data(), size);
  text.resize(copied > 0 ? static_cast<std::size_t>(copied) : 0);
  return text;
}

bool read_request(lws* wsi, Request& request, Response& refusal) {
  static constexpr const char* kMethods[] = {"GET", "POST", "OPTIONS", "PUT", "PATCH", "DELETE", "CONNECT", "HEAD"};
  std::string peer = std::move(request.peer);
  request = {};
  request.peer = std::move(peer);
  char* uri = nullptr;
  int uri_length = 0;
  const int method = lws_http_get_uri_and_method(wsi, &uri, &uri_length);
  if (method < 0 || method >= static_cast<int>(std::size(kMethods)) || !uri) {
    refusal = plain(405, "unknown method");
    return false;
  }
  request.method = kMethods[method];
  request.path.assign(uri, static_cast<std::size_t>(uri_length));
  if (!is_plain_path(request.path)) {
    refusal = plain(400, "the path has parts that no path here has");
    return false;
  }
  for (int i = 0; const int length = lws_hdr_fragment_length(wsi, WSI_TOKEN_HTTP_URI_ARGS, i); ++i) {
    std::array<char, 1024> text{};
    const int copied = length < static_cast<int>(text.size())
                           ? lws_hdr_copy_fragment(wsi, text.data(), text.size(), WSI_TOKEN_HTTP_URI_ARGS, i)
                           : -1;
    if (copied < 0) {
      refusal = plain(400, "an argument of the query is longer than 1023 bytes");
      return false;
    }
    const std::string_view part(text.data(), static_cast<std::size_t>(copied));
    const std::size_t equals = part.find('=');
    request.query.emplace_back(part.substr(0, equals),
                               equals == std::string_view::npos ? std::string_view() : part.substr(equals + 1));
  }
  request.host = header_of(wsi, WSI_TOKEN_HOST);
  request.origin = header_of(wsi, WSI_TOKEN_ORIGIN);
  request.authorization = header_of(wsi, WSI_TOKEN_HTTP_AUTHORIZATION);
  request.if_none_match = header_of(wsi, WSI_TOKEN_HTTP_IF_NONE_MATCH);
  request.content_type = header_of(wsi, WSI_TOKEN_HTTP_CONTENT_TYPE);
  request.accept_encoding = header_of(wsi, WSI_TOKEN_HTTP_ACCEPT_ENCODING);
  request.until_ns = custom_header(wsi, "x-sinew-until-ns:");
  request.control_key = custom_header(wsi, "x-sinew-control:");
  return true;
}

}  // namespace sinew::monitor
