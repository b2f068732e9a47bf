#include "record/run/part.hpp"

#include <algorithm>
#include <map>

#include "record/run/recorded_run.hpp"
#include "record/run/ros2_convert.hpp"
#include "record/run/run_messages.hpp"
#include "record/run/run_sink.hpp"
#include "record/run/verdict.hpp"

namespace sinew::record {
namespace {

/// By thread: order of the first entry of its log from then on.
std::map<std::uint32_t, std::uint64_t> first_orders(Reader& reader, std::uint64_t from) {
  std::map<std::uint32_t, std::uint64_t> first;
  const auto entry = [&](std::uint32_t thread, std::uint64_t order) {
    const auto [at, is_new] = first.emplace(thread, order);
    if (!is_new) at->second = std::min(at->second, order);
  };
  const std::size_t threads = read_metadata(reader, "sinew.threads").size();
  MessageReader messages =
      reader.messages({.topics = {std::string(kStepsTopic), std::string(kRequestsTopic), std::string(kStatesTopic)},
                       .from = from,
                       .order = Order::file});
  std::vector<LoggedStep> batch;
  LoggedRequest request;
  LoggedState state;
  std::uint64_t layout = 0;
  Message m;
  for (Next next; first.size() < threads && (next = messages.next(m)) != Next::end;) {
    if (next == Next::problem) continue;  // reading the messages reports it
    if (m.channel->topic == kStepsTopic && decode(m.data, batch))
      for (const LoggedStep& s : batch) entry(s.thread, s.order);
    else if (m.channel->topic == kRequestsTopic && decode(m.data, request))
      entry(request.request.thread, request.order);
    else if (m.channel->topic == kStatesTopic && decode(m.data, state, layout))
      entry(state.thread, state.order);
  }
  return first;
}

}  // namespace

CopyChanges changes_of_cut(Reader& reader, std::uint64_t from) {
  const Texts run = read_metadata(reader, "sinew.run");
  if (run.empty() || from <= recorded_start(reader)) return {};
  Texts begin{{"at_ns", std::to_string(static_cast<std::int64_t>(from) - unix_ns_of(reader))}};
  for (const auto& [thread, order] : first_orders(reader, from)) begin[number_key(thread)] = std::to_string(order);
  return {{{std::string(kBeginName), std::move(begin)}, {std::string(kFromName), {}}}, {std::string(kRequestsTopic)}};
}

CopyChanges changes_of_merge(std::span<Reader* const> readers) {
  const bool any = std::any_of(readers.begin(), readers.end(),
                               [](Reader* reader) { return !read_metadata(*reader, kBeginName).empty(); });
  if (!any) return {};
  Reader& first = **std::min_element(readers.begin(), readers.end(),
                                     [](Reader* a, Reader* b) { return recorded_start(*a) < recorded_start(*b); });
  CopyChanges changes;
  for (const std::string_view name : {kBeginName, kFromName, std::string_view("sinew.params")})
    changes.metadata.push_back({std::string(name), read_metadata(first, name)});
  return changes;
}

}  // namespace sinew::record
