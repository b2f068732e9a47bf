// record start, stop, status, snapshot: what a running robot records.
#include <fmt/format.h>

#include <cstdio>

#include "apps/live/commands.hpp"
#include "apps/live/live_command.hpp"

namespace sinew::app {
namespace {

double megabytes(const Json& of, const char* key) { return 1e-6 * of.value(key, 0.0); }

std::string replayable_text(const Json& file) {
  std::size_t bad = 0;
  for (const auto& [module, reasons] : file.at("not_replayable").items()) bad += !reasons.empty();
  return bad == 0 ? "every module can be replayed" : fmt::format("{} modules cannot be replayed wholly", bad);
}

std::string start_text(const Json& reply) { return "records to " + reply.value("path", std::string()); }

std::string stop_text(const Json& reply) {
  return fmt::format("{}, {:.1f} MB; {}", reply.value("path", std::string()), megabytes(reply, "bytes"),
                     replayable_text(reply));
}

std::string snapshot_text(const Json& reply) {
  return fmt::format("{}, {:.1f} MB", reply.value("path", std::string()), megabytes(reply, "bytes"));
}

std::string ring_text(const Json& ring) {
  std::string text = fmt::format("the last {:.1f} s in memory, {:.1f} of {:.1f} MB", ring.value("seconds", 0.0),
                                 megabytes(ring, "bytes"), megabytes(ring, "room_bytes"));
  for (const Json& dump : ring.at("dumps")) {
    text += fmt::format("\n  {}: {} at {:.3f} s", dump.value("path", std::string()),
                        dump.value("reason", std::string()), dump.value("at_s", 0.0));
    if (dump.contains("error"))
      text += ": " + dump.at("error").get<std::string>();
    else if (!dump.value("done", true))
      text += ", being written";
  }
  if (const auto more = ring.value("not_dumped", std::uint64_t{0}); more != 0)
    text += fmt::format("\n  {} more within the ring's length of another", more);
  return text;
}

std::string status_text(const Json& reply) {
  const Json &file = reply.at("recording"), &ring = reply.at("ring");
  std::string text = "nothing is being recorded";
  if (!file.is_null())
    text = fmt::format("records to {}: {:.1f} s, {:.1f} MB, {} messages and {} steps lost",
                       file.value("path", std::string()), file.value("seconds", 0.0), megabytes(file, "bytes"),
                       file.value("lost_messages", std::uint64_t{0}), file.value("lost_steps", std::uint64_t{0}));
  return text + (ring.is_null() ? "\nno flight ring" : "\n" + ring_text(ring));
}

int ask(const LiveOptions& options, const char* request, std::string (*text)(const Json&)) {
  auto robot = LiveRobot::find(options);
  if (!robot) return kNotBegun;
  auto reply = robot->ask(request);
  if (!reply) return kFailed;
  reply->erase("ok");
  if (options.json)
    std::printf("%s", to_line(*reply).c_str());
  else
    std::printf("%s: %s\n", robot->name().c_str(), text(*reply).c_str());
  return kDone;
}

int record_start(const LiveOptions& o) { return ask(o, "record.start", start_text); }
int record_stop(const LiveOptions& o) { return ask(o, "record.stop", stop_text); }
int record_status(const LiveOptions& o) { return ask(o, "record.status", status_text); }
int record_snapshot(const LiveOptions& o) { return ask(o, "record.snapshot", snapshot_text); }

}  // namespace

void add_record_commands(CLI::App& app, CommandContext& context) {
  CLI::App& record = *app.add_subcommand("record", "what a running robot records");
  record.require_subcommand(1);
  live_command(record, context, "start", "begin a recording, in a folder of its own", record_start);
  live_command(record, context, "stop", "complete it; the robot goes on", record_stop);
  live_command(record, context, "status", "where to, how much, what was lost; the flight ring", record_status);
  live_command(record, context, "snapshot", "write the last seconds of the flight ring to a file", record_snapshot);
}

}  // namespace sinew::app
