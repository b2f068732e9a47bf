#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "apps/bag/bag_options.hpp"
#include "apps/bag/run_text.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "apps/robot_file/world_report.hpp"
#include "apps/run/run_metadata.hpp"
#include "record/run/recorded_run.hpp"

namespace sinew::app {
namespace {

struct Stored {
  std::uint64_t chunks = 0, bytes = 0, uncompressed_bytes = 0;
};

std::map<std::string, Stored> by_compression(const record::Reader& reader) {
  std::map<std::string, Stored> all;
  for (const auto& chunk : reader.chunks()) {
    Stored& s = all[chunk.compression.empty() ? "none" : chunk.compression];
    ++s.chunks;
    s.bytes += chunk.compressed_size;
    s.uncompressed_bytes += chunk.uncompressed_size;
  }
  return all;
}

struct TopicLine {
  std::string name, type;
  std::uint64_t messages = 0;
  double rate_hz = 0;
};

std::vector<TopicLine> topic_lines(record::Reader& reader) {
  std::vector<TopicLine> lines;
  for (const auto& [id, channel] : reader.channels()) {
    TopicLine line{channel.topic, ""};
    if (const auto schema = reader.schemas().find(channel.schema); schema != reader.schemas().end())
      line.type = schema->second.name;
    if (reader.statistics())
      if (const auto n = reader.statistics()->channel_messages.find(id);
          n != reader.statistics()->channel_messages.end())
        line.messages = n->second;
    line.rate_hz = channel_rate_hz(reader, channel);
    lines.push_back(std::move(line));
  }
  std::sort(lines.begin(), lines.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return lines;
}

std::string pairs_text(const record::Texts& texts, const char* indent) {
  std::string out;
  for (const auto& [key, value] : texts) out += fmt::format("{}{:<18} {}\n", indent, key, value);
  return out;
}

std::vector<std::string> listed(record::Reader& reader, std::string_view name) {
  std::vector<std::string> all;
  for (const auto& [number, text] : read_metadata(reader, name)) all.push_back(text);
  return all;
}

Json report_json(record::Reader& reader) {
  const auto report = record::read_attachment(reader, kReportFile);
  if (!report) return {};
  Json json = Json::parse(*report, nullptr, false);
  return json.is_discarded() ? Json(*report) : json;
}

/// The plant's report: what it measured, what its faults did, then its other keys as they are.
std::string report_text(record::Reader& reader) {
  const auto text = record::read_attachment(reader, kReportFile);
  if (!text) return {};
  std::string out = "report of the simulator\n";
  if (const auto report = parse_report(*text)) {
    const auto add = [&out](const std::string& key, const std::string& value) {
      out += fmt::format("  {:<18} {}\n", key, value);
    };
    if (report->verdict) {
      add("outcome", report->verdict->outcome);
      for (const auto* all : {&report->verdict->measures, &report->verdict->conditions})
        for (const WorldReport::Measure& m : *all) add(m.key, in_words(m));
    }
    for (const WorldReport::Fault& f : report->faults)
      add("fault", fmt::format("{}: struck {} times{}", f.text, f.affected,
                               f.first_s ? fmt::format(", first after {:.3f} s", *f.first_s) : ""));
  }
  const Json all = report_json(reader);  // outlives the loop over it
  for (const auto& [key, value] : all.items())
    if (value.is_primitive())
      out += fmt::format("  {:<18} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
  return out;
}

std::string list_text(record::Reader& reader, std::string_view name, const char* title) {
  std::string out;
  for (const std::string& text : listed(reader, name)) out += fmt::format("  {}\n", text);
  return out.empty() ? out : fmt::format("{}\n{}", title, out);
}

/// What was asked of the run, and how it went.
std::string run_text(record::Reader& reader) {
  std::string out;
  if (const auto run = read_metadata(reader, "sinew.run"); !run.empty()) out += "run\n" + pairs_text(run, "  ");
  out += list_text(reader, kOptionsName, "options");
  if (const auto world = read_metadata(reader, kWorldName); !world.empty()) out += "world\n" + pairs_text(world, "  ");
  out += list_text(reader, kFaultsName, "faults asked for");
  if (const auto result = read_metadata(reader, record::kResultName); !result.empty())
    out += "result\n" + pairs_text(result, "  ");
  if (const std::string why = why_no_result(reader); !why.empty()) out += fmt::format("result\n  none: {}\n", why);
  return out + report_text(reader);
}

Json run_json(record::Reader& reader) {
  const std::string why_none = why_no_result(reader);
  const auto result = read_metadata(reader, record::kResultName);
  Json json{{"run", read_metadata(reader, "sinew.run")},
            {"options", listed(reader, kOptionsName)},
            {"world", read_metadata(reader, kWorldName)},
            {"plant_arguments", listed(reader, kPlantArgumentsName)},
            {"faults", listed(reader, kFaultsName)},
            {"result", result.empty() ? Json() : Json(result)},
            {"report", report_json(reader)}};
  if (!why_none.empty()) json["no_result"] = why_none;
  return json;
}

Json info_json(const BagOptions& options, std::uint64_t bytes, record::Reader& reader, double duration_s) {
  Json topics = Json::array(), compression = Json::object(), attachments = Json::array(), metadata = Json::array(),
       problems = Json::array();
  for (const TopicLine& t : topic_lines(reader))
    topics.push_back({{"name", t.name}, {"type", t.type}, {"messages", t.messages}, {"rate_hz", t.rate_hz}});
  for (const auto& [name, s] : by_compression(reader))
    compression[name] = {{"chunks", s.chunks}, {"bytes", s.bytes}, {"uncompressed_bytes", s.uncompressed_bytes}};
  for (const auto& a : reader.attachments())
    attachments.push_back({{"name", a.name}, {"media_type", a.media_type}, {"bytes", a.data_size}});
  for (const auto& m : reader.metadata()) metadata.push_back(m.name);
  for (const auto& p : reader.problems()) problems.push_back(to_string(p));
  Json json{{"file", options.file},
            {"bytes", bytes},
            {"whole", reader.by_summary()},
            {"profile", reader.header().profile},
            {"library", reader.header().library},
            {"start_ns", record::recorded_start(reader)},
            {"end_ns", end_time(reader)},
            {"duration_s", duration_s},
            {"messages", reader.statistics() ? Json(reader.statistics()->messages) : Json()},
            {"topics", topics},
            {"compression", compression},
            {"attachments", attachments},
            {"metadata", metadata},
            {"dump", read_metadata(reader, "sinew.dump")},
            {"verdict", read_metadata(reader, "sinew.verdict")},
            {"losses", read_metadata(reader, "sinew.losses")},
            {"problems", problems}};
  json.update(run_json(reader));
  return json;
}

std::string info_text(const BagOptions& options, std::uint64_t bytes, record::Reader& reader, double duration_s) {
  std::string out = fmt::format("{}: {:.1f} MB, {:.3f} s", options.file, 1e-6 * static_cast<double>(bytes), duration_s);
  if (reader.statistics()) out += fmt::format(", {} messages", reader.statistics()->messages);
  out += "\n";
  out += run_text(reader);
  if (const auto dump = read_metadata(reader, "sinew.dump"); !dump.empty())
    out += "dump of the flight ring\n" + pairs_text(dump, "  ");
  out += fmt::format("\n{:<28} {:<30} {:>9} {:>10}\n", "topic", "type", "messages", "per second");
  for (const TopicLine& t : topic_lines(reader))
    out += fmt::format("{:<28} {:<30} {:>9} {:>10}\n", t.name, t.type, t.messages,
                       t.rate_hz > 0 ? fmt::format("{:.4g}", t.rate_hz) : "-");
  out += "\n";
  for (const auto& [name, s] : by_compression(reader))
    out += fmt::format("{} chunks {}: {:.1f} MB of {:.1f} MB\n", s.chunks,
                       name == "none" ? "without compression" : "with " + name, 1e-6 * static_cast<double>(s.bytes),
                       1e-6 * static_cast<double>(s.uncompressed_bytes));
  for (const auto& a : reader.attachments())
    out += fmt::format("attachment {} ({}, {} B)\n", a.name, a.media_type, a.data_size);
  std::string names;
  for (const auto& m : reader.metadata()) names += " " + m.name;
  if (!names.empty()) out += "metadata" + names + "\n";
  const auto verdict = read_metadata(reader, "sinew.verdict"), losses = read_metadata(reader, "sinew.losses");
  if (!verdict.empty()) out += "\nmodules\n" + pairs_text(verdict, "  ");
  if (!losses.empty()) out += "lost\n" + pairs_text(losses, "  ");
  return out;
}

int info_of_file(const BagOptions& options) {
  Progress progress("reading");
  auto file = open_input(options.file, progress);
  if (!file) return kNotBegun;
  const std::uint64_t bytes = file->size();
  record::FileProblem why;
  auto reader = record::Reader::open(std::move(file), why);
  if (!reader) return fail(options.file + ": " + to_string(why));
  const double duration_s = 1e-9 * static_cast<double>(end_time(*reader) - record::recorded_start(*reader));
  std::printf("%s", options.json ? to_line(info_json(options, bytes, *reader, duration_s)).c_str()
                                 : info_text(options, bytes, *reader, duration_s).c_str());
  say_problems(options.file, reader->problems());
  if (!reader->by_summary())
    std::fprintf(
        stderr,
        "the summary is missing or damaged; this is what can be read. `bag recover %s OUT` makes a whole file of it\n",
        options.file.c_str());
  return kDone;
}

}  // namespace

int bag_info(const BagInfoOptions& options) {
  const auto files = each_file_once(options.files);
  int worst = kDone;
  for (const std::string& file : files) {
    BagOptions one = options;
    one.file = file;
    if (&file != files.data() && !options.json) std::printf("\n");
    worst = std::max(worst, info_of_file(one));
  }
  return worst;
}

}  // namespace sinew::app
