#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "apps/bag/bag_options.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
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
  return {{"file", options.file},
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
          {"run", read_metadata(reader, "sinew.run")},
          {"dump", read_metadata(reader, "sinew.dump")},
          {"verdict", read_metadata(reader, "sinew.verdict")},
          {"losses", read_metadata(reader, "sinew.losses")},
          {"problems", problems}};
}

std::string info_text(const BagOptions& options, std::uint64_t bytes, record::Reader& reader, double duration_s) {
  std::string out = fmt::format("{}: {:.1f} MB, {:.3f} s", options.file, 1e-6 * static_cast<double>(bytes), duration_s);
  if (reader.statistics()) out += fmt::format(", {} messages", reader.statistics()->messages);
  out += "\n";
  if (const auto run = read_metadata(reader, "sinew.run"); !run.empty()) out += "run\n" + pairs_text(run, "  ");
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
