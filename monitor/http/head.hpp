#pragma once
// Heads of HTTP as libwebsockets has parsed them. Inside of the room only.
#include <string>
#include <string_view>

#include "monitor/http/message.hpp"

struct lws;

namespace sinew::monitor {

/// The value of a header that the library knows by itself (lws_token_indexes); empty: it was not sent.
std::string header_of(lws* wsi, int token);
/// The same of any other one; `name` in lower case, with its colon.
std::string custom_header(lws* wsi, std::string_view name);

/// False: what the peer sent is no request that anybody may handle; `refusal` says why. `request` keeps its `peer`.
bool read_request(lws* wsi, Request& request, Response& refusal);

}  // namespace sinew::monitor
