#include "monitor/site.hpp"

#include <utility>

#include "monitor/json_reply.hpp"

namespace sinew::monitor {

Headers protective_headers() {
  return {{"content-security-policy",
           "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
           "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
          {"x-content-type-options", "nosniff"},
          {"x-frame-options", "DENY"},
          {"referrer-policy", "no-referrer"},
          {"cross-origin-resource-policy", "same-origin"}};
}

namespace {

RobotApi::Options api_options(RobotApi::Options options, const Page& page, const Runs& runs) {
  options.panels = page.panels(), options.runs = runs.are_shown();
  return options;
}

}  // namespace

Site::Site(Robots& robots, Server& server, Options options)
    : gate_(std::move(options.gate)),
      page_(options.panels),
      runs_(robots, server, gate_, options.sinew, std::move(options.runs)),
      doctor_(server, options.sinew),
      api_(robots, gate_, api_options(std::move(options.api), page_, runs_)),
      feeds_(robots, server),
      pictures_(feeds_, server),
      live_(robots, feeds_, server),
      monitors_(server, gate_, [this](const std::string& address) { relay_.cut(address); }),
      relay_(server, gate_, monitors_) {}

void Site::answer(Request request, ConnectionId connection, const Server::Reply& reply) {
  const bool is_api = RobotApi::has(request.path);
  if (const auto refusal = gate_.refuses(request))
    return reply(is_api ? json_error(refusal->status, "denied", refusal->why) : plain(refusal->status, refusal->why));
  const bool reads = request.method == "GET" || request.method == "HEAD";
  if (Relay::has(request.path)) return relay_.answer(request, connection, reply);
  if (runs_.answer(request, reply)) return;
  if (reads && request.path == Doctor::kPath) return doctor_.answer(reply);
  if (Monitors::has(request.path)) return monitors_.answer(request, reply);
  if (is_api) return api_.answer(request, reply);
  if (!reads) {
    Response r = plain(405, "only GET and HEAD here");
    r.headers = {{"allow", "GET, HEAD"}};
    return reply(std::move(r));
  }
  if (page_.answer(request, reply) || pictures_.answer(request, connection, reply)) return;
  reply(plain(404, "nothing here; GET /api/robots lists the robots"));
}

std::unique_ptr<Socket> Site::open_socket(const Request& request, ConnectionId connection, Response& refusal) {
  auto refused = gate_.refuses(request);
  if (!refused && Relay::has(request.path)) return relay_.open_socket(request, connection, refusal);
  const std::string* const token = request.argument("token");
  if (!refused && token) refused = gate_.refuses_token(*token, request.peer);
  if (refused) {
    refusal = plain(refused->status, refused->why);
    return nullptr;
  }
  const std::string* const key = request.argument("control");
  return live_.open(
      request, connection, token != nullptr,
      [this, key = key ? *key : std::string()](const std::string& robot, const std::string& what) {
        return api_.busy_with(robot, what, key);
      },
      refusal);
}

}  // namespace sinew::monitor
