// bag cat, csv: messages as text.
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "apps/bag/bag_message.hpp"
#include "apps/bag/bag_options.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

std::string quoted(const std::string& text) { return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace); }

using Row = std::vector<std::pair<std::string, std::string>>;

std::string csv_cell(std::string text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2) text.insert(at, 1, '"');
  return '"' + text + '"';
}

/// One column for each number: "p_world_m.x", "value.0".
void flatten(const Json& json, const std::string& name, Row& row) {
  if (!json.is_structured()) {
    row.emplace_back(name, json.is_string() ? json.get<std::string>() : json.dump());
    return;
  }
  std::size_t index = 0;
  for (const auto& [key, value] : json.items()) {
    const std::string inner = json.is_array() ? std::to_string(index++) : key;
    flatten(value, name.empty() ? inner : name + "." + inner, row);
  }
}

class Table {
 public:
  explicit Table(std::FILE* out) : out_(out) {}
  /// False: this row has other columns than the rows before.
  bool add(const Row& row) {
    if (columns_.empty()) {
      for (const auto& [name, value] : row) columns_.push_back(name);
      line(row, &Row::value_type::first);
    }
    const bool same = std::equal(row.begin(), row.end(), columns_.begin(), columns_.end(),
                                 [](const auto& cell, const auto& name) { return cell.first == name; });
    if (same) line(row, &Row::value_type::second), ++rows_;
    return same;
  }
  std::uint64_t rows() const { return rows_; }

 private:
  void line(const Row& row, std::string Row::value_type::*part) {
    std::string text;
    for (const auto& cell : row) text += (text.empty() ? "" : ",") + csv_cell(cell.*part);
    text += "\n";
    std::fwrite(text.data(), 1, text.size(), out_);
  }
  std::FILE* out_;
  std::vector<std::string> columns_;
  std::uint64_t rows_ = 0;
};

bool add_message(Table& table, const record::Message& m, BagMessages& texts, std::string& text) {
  text.clear();
  if (!texts.append_json(m, text)) return true;  // append_json() has printed why
  Row row{{"log_time_ns", std::to_string(m.stamps.log_time)}, {"sequence", std::to_string(m.stamps.sequence)}};
  flatten(Json::parse(text, nullptr, false), "", row);
  if (table.add(row)) return true;
  return fail(m.channel->topic + ": its messages hold lists of different lengths; `bag cat` shows those", kFailed) == 0;
}

}  // namespace

int bag_cat(const BagCatOptions& options) {
  Progress progress("cat", !hal::output_is_terminal());
  const auto reader = open_recording(options.file, progress);
  const auto query = reader ? query_of(*reader, options.what) : std::nullopt;
  if (!query) return kNotBegun;
  BagMessages texts(*reader);
  std::string line;
  bool written = true;
  const bool good = each_message(*reader, *query, [&](const record::Message& m) {
    line = "{\"topic\":" + quoted(m.channel->topic) + ",\"sequence\":" + std::to_string(m.stamps.sequence) +
           ",\"log_time_ns\":" + std::to_string(m.stamps.log_time) +
           ",\"stamp_ns\":" + std::to_string(m.stamps.publish_time) + ",\"message\":";
    if (!texts.append_json(m, line)) return true;
    line += "}\n";
    return written = std::fwrite(line.data(), 1, line.size(), stdout) == line.size();
  });
  return std::fflush(stdout) == 0 && written && good && texts.unknown() == 0 ? kDone : kFailed;
}

int bag_csv(const BagTopicOptions& options) {
  bool good = false;
  std::uint64_t rows = 0;
  {
    Progress progress("csv", !options.out.empty() || !hal::output_is_terminal());
    const auto reader = open_recording(options.file, progress);
    const auto query = reader ? query_of(*reader, options.what) : std::nullopt;
    if (!query) return kNotBegun;
    std::FILE* const out = options.out.empty() ? stdout : std::fopen(options.out.c_str(), "wx");
    if (!out)
      return fail(options.out + ": " + (errno == EEXIST ? "exists; nothing is overwritten" : std::strerror(errno)));
    BagMessages texts(*reader);
    Table table(out);
    std::string text;
    bool one_table = true;
    good = each_message(*reader, *query,
                        [&](const record::Message& m) { return one_table = add_message(table, m, texts, text); });
    rows = table.rows();
    good = good && one_table && texts.unknown() == 0;
    if ((out == stdout ? std::fflush(out) : std::fclose(out)) != 0)
      return fail(options.out + ": " + std::strerror(errno), kFailed);
  }
  if (options.json && !options.out.empty()) std::printf("%s", to_line({{"file", options.out}, {"rows", rows}}).c_str());
  return good ? kDone : kFailed;
}

}  // namespace sinew::app
