#include "monitor/doctor.hpp"

#include <utility>

#include "monitor/json_reply.hpp"

namespace sinew::monitor {

void Doctor::answer(Server::Reply reply) {
  if (!reply_.empty() && Clock::now() - at_ <= kAge) return reply(json_response(200, reply_));
  if (waiting_.size() >= kMostWaiting) return reply(json_error(409, "busy", "too many wait for the doctor"));
  waiting_.push_back(std::move(reply));
  if (program_) return;
  program_ = std::make_unique<Program>(std::vector<std::string>{sinew_, "doctor", "--json"}, ProgramLimits{},
                                       [this](const ProgramEnd& end) { server_.post([this, end] { ended(end); }); });
}

void Doctor::ended(const ProgramEnd& end) {
  program_ = nullptr;  // its thread has called us and returns: nothing to wait for
  Json said = Json::parse(end.output, nullptr, false);
  std::vector<Server::Reply> waiting;
  waiting.swap(waiting_);
  if (!end.why.empty() || !said.is_object()) {
    for (const Server::Reply& reply : waiting) reply(json_error(502, "io", "sinew doctor: " + reason(end)));
    return;
  }
  Json whole{{"ok", true}};
  whole.update(said);
  reply_ = to_text(whole), at_ = Clock::now();
  for (const Server::Reply& reply : waiting) reply(json_response(200, reply_));
}

}  // namespace sinew::monitor
