// The way in: what any thread may ask of a configured graph, checked before it goes into a mailbox.
#include "hal/did_you_mean.hpp"
#include "rt/external_source.hpp"
#include "rt/graph.hpp"
#include "rt/graph_check.hpp"
#include "rt/graph_names.hpp"
#include "rt/parameters.hpp"

namespace sinew::rt {
namespace {

hal::Error refuse(std::string* why, hal::Errc code, const char* where, std::string words) {
  if (why) *why = std::move(words);
  return {code, where};
}

std::vector<std::string> names_of(const std::vector<Declaration::Param>& params) {
  std::vector<std::string> names;
  for (const auto& p : params) names.emplace_back(p.name);
  return names;
}

}  // namespace

std::string no_such_module(const Graph& graph, std::string_view name) {
  std::vector<std::string> names;
  for (const GraphModule& m : graph.modules()) names.push_back(m.spec.name);
  return "no module " + std::string(name) + "; there are: " + listed_for(name, names);
}

std::string no_such_topic(const Graph& graph, std::string_view name) {
  std::vector<std::string> names;
  for (const GraphTopic& t : graph.topics()) names.push_back(t.name);
  return "no topic " + std::string(name) + hal::did_you_mean(name, names);
}

std::string no_such_thread(const Graph& graph, std::string_view name) {
  std::vector<std::string> names;
  for (const GraphThread& t : graph.threads()) names.push_back(t.spec.name);
  return "no thread " + std::string(name) + "; there are: " + listed_for(name, names);
}

hal::Result<Ticket> Graph::post(Request request, std::string* why) {
  if (mailboxes_.empty()) return refuse(why, hal::Errc::not_supported, "mailbox", "the graph is not configured yet");
  auto number = mailboxes_[request.thread]->post(request);
  if (number) return Ticket{request.thread, *number};
  busy_posts_.add();
  return refuse(why, number.error().code, number.error().where,
                "the mailbox of thread " + threads_[request.thread].spec.name + " is full");
}

hal::Result<Ticket> Graph::set_param(std::string_view module, std::string_view name, const ParamValue& value,
                                     std::string* why) {
  const std::uint32_t m = find_module(module);
  if (m == kNone) return refuse(why, hal::Errc::not_found, "module", no_such_module(*this, module));
  const Declaration::Param* p = find_param(modules_[m].declaration, name);
  if (!p)
    return refuse(why, hal::Errc::not_found, "parameter",
                  std::string(module) + " has no parameter " + std::string(name) +
                      "; it has: " + listed_for(name, names_of(modules_[m].declaration.params)));
  if (std::holds_alternative<std::string*>(p->target))
    return refuse(why, hal::Errc::not_supported, "parameter", "a text is set before the start only");
  const auto index = static_cast<std::uint32_t>(p - modules_[m].declaration.params.data());
  const std::optional<ParamRange> none, &narrowed = mailboxes_.empty() ? none : modules_[m].narrowed[index];
  if (!accepts(*p, value, narrowed))
    return refuse(
        why, hal::Errc::bad_argument, "parameter",
        std::string(module) + "." + std::string(name) + ": " + to_string(value) + ": " + allowed_values(*p, narrowed));
  Request request;
  request.thread = modules_[m].thread;
  request.module = m;
  request.index = index;
  if (const auto* b = std::get_if<bool>(&value)) request.value = *b;
  if (const auto* i = std::get_if<std::int64_t>(&value)) request.value = *i;
  if (const auto* d = std::get_if<double>(&value)) request.value = *d;
  return post(request, why);
}

hal::Result<Ticket> Graph::set_enabled(std::string_view module, bool enabled, std::string* why) {
  Request request;
  request.kind = enabled ? Request::Kind::enable : Request::Kind::disable;
  request.module = find_module(module);
  if (request.module == kNone) return refuse(why, hal::Errc::not_found, "module", no_such_module(*this, module));
  const GraphModule& m = modules_[request.module];
  if (m.guardian || m.external)
    return refuse(why, hal::Errc::not_supported, "module",
                  std::string(module) + " belongs to the runtime; it stays on");
  request.thread = m.thread;
  return post(request, why);
}

hal::Result<Ticket> Graph::set_period(std::string_view thread, Duration period, std::string* why) {
  const std::uint32_t t = find_thread(thread);
  if (t == kNone) return refuse(why, hal::Errc::not_found, "thread", no_such_thread(*this, thread));
  if (threads_[t].spec.trigger != ThreadSpec::Trigger::period)
    return refuse(why, hal::Errc::not_supported, "thread", std::string(thread) + " is not released by a period");
  if (period < kShortestPeriod || period > kLongestPeriod)
    return refuse(why, hal::Errc::bad_argument, "period", in_us(period) + " us: a number from 10 to 3600000000");
  Request request;
  request.kind = Request::Kind::set_period;
  request.thread = t;
  request.value = std::int64_t{period.count()};
  return post(request, why);
}

hal::Result<Ticket> Graph::arm(std::string* why) { return ask_guardian(Request::Kind::arm, why); }

hal::Result<Ticket> Graph::disarm(std::string* why) { return ask_guardian(Request::Kind::disarm, why); }

hal::Result<Ticket> Graph::ask_guardian(Request::Kind kind, std::string* why) {
  if (modules_.empty() || !modules_[0].guardian)
    return refuse(why, hal::Errc::not_supported, "guardian", "this robot has no actuators and so no guardian");
  Request request;
  request.kind = kind;
  return post(request, why);  // thread 0, module 0
}

/// Why an external topic does not take a message.
std::string Graph::why_not_staged(std::uint32_t topic, const OutsideMessage& message, const hal::Error& error) const {
  const GraphModule& writer = modules_[topics_[topic].writer];
  const msg::TypeInfo& type = *topics_[topic].type;
  const std::string length = std::to_string(message.length()) + " bytes: ";
  if (error.code == hal::Errc::busy)
    return std::to_string(writer.external->room(topics_[topic].port)) + " messages of " +
           (type.has_bulk() ? topics_[topic].name : writer.spec.name) + " wait already";
  if (error.code == hal::Errc::bad_data) return length + error.where;
  if (error.where == std::string_view("not finite")) return "not finite: finite numbers in every field";
  if (error.where != std::string_view("size of the message")) return error.where;
  std::string has = std::string(type.name) + " has " + std::to_string(type.size);
  if (type.has_bulk()) has += ", and behind it at most " + std::to_string(topics_[topic].image_bytes) + " of pixels";
  return length + has;
}

hal::Result<Ticket> Graph::publish(std::string_view topic, const OutsideMessage& message, std::string* why) {
  const std::uint32_t t = find_topic(topic);
  if (t == kNone) return refuse(why, hal::Errc::not_found, "topic", no_such_topic(*this, topic));
  const GraphModule& writer = modules_[topics_[t].writer];
  if (!writer.external)
    return refuse(why, hal::Errc::not_supported, "topic",
                  std::string(topic) + " is written by module " + writer.spec.name +
                      "; only topics with writer = \"external\" take messages");
  if (mailboxes_.empty()) return refuse(why, hal::Errc::not_supported, "mailbox", "the graph is not configured yet");
  const auto place = writer.external->stage(topics_[t].port, message);
  if (!place) {
    if (place.error().code == hal::Errc::busy) busy_posts_.add();
    return refuse(why, place.error().code, place.error().where, why_not_staged(t, message, place.error()));
  }
  Request request;
  request.kind = Request::Kind::message;
  request.thread = writer.thread;
  request.module = topics_[t].writer;
  request.index = *place;
  auto ticket = post(request, why);
  if (!ticket) writer.external->unstage(*place);
  return ticket;
}

hal::Result<Ticket> Graph::publish(std::string_view topic, std::span<const std::byte> message, std::string* why) {
  return publish(topic, OutsideMessage{.bytes = message}, why);
}

std::optional<Effect> Graph::effect(Ticket ticket) const {
  if (ticket.thread >= mailboxes_.size()) return std::nullopt;
  return mailboxes_[ticket.thread]->effect(ticket.number);
}

}  // namespace sinew::rt
