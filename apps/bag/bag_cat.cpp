// bag cat, csv: messages as text.
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <functional>
#include <unordered_set>

#include "apps/bag/bag_message.hpp"
#include "apps/bag/bag_options.hpp"
#include "apps/bag/field_remark.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

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

/// Rows with the columns of all of them, in the order that they have in each. The columns are known before the rows.
class Table {
 public:
  explicit Table(std::FILE* out) : out_(out) {}
  void add_columns(const Row& row) {
    std::size_t at = 0;
    for (const auto& cell : row) {
      if (at == columns_.size() || columns_[at] != cell.first) {
        const bool is_new = known_.insert(cell.first).second;
        const auto there = is_new ? columns_.end() : std::find(columns_.begin(), columns_.end(), cell.first);
        if (is_new)
          columns_.insert(columns_.begin() + static_cast<std::ptrdiff_t>(at), cell.first);
        else
          at = static_cast<std::size_t>(there - columns_.begin());
      }
      ++at;
    }
  }
  void add(const Row& row) {
    if (rows_++ == 0) head();
    std::string text;
    auto cell = row.begin();
    for (const std::string& column : columns_) {
      if (&column != columns_.data()) text += ",";
      if (cell != row.end() && cell->first == column) text += csv_cell((cell++)->second);
    }
    put(text);
  }
  std::uint64_t rows() const { return rows_; }

 private:
  void head() {
    std::string text;
    for (const std::string& column : columns_) text += (text.empty() ? "" : ",") + csv_cell(column);
    put(text);
  }
  void put(std::string& line) {
    line += "\n";
    std::fwrite(line.data(), 1, line.size(), out_);
  }
  std::FILE* out_;
  std::vector<std::string> columns_;
  std::unordered_set<std::string> known_;
  std::uint64_t rows_ = 0;
};

/// Nothing: append_json() has printed why.
std::optional<Row> row_of(const record::Message& m, BagMessages& texts, bool names, std::string& text) {
  text.clear();
  if (!texts.append_json(m, text)) return std::nullopt;
  Json message = Json::parse(text, nullptr, false);
  if (const auto* schema = texts.schema(*m.channel); names && schema) add_names(message, *schema);
  Row row{{"log_time_ns", std::to_string(m.stamps.log_time)}, {"sequence", std::to_string(m.stamps.sequence)}};
  flatten(message, "", row);
  return row;
}

/// Whether messages of the topic may hold lists of different lengths.
bool has_lists(const record::Reader& reader, const std::vector<std::string>& topics) {
  return std::any_of(reader.channels().begin(), reader.channels().end(), [&](const auto& entry) {
    const auto schema = reader.schemas().find(entry.second.schema);
    const bool asked = std::find(topics.begin(), topics.end(), entry.second.topic) != topics.end();
    return asked && schema != reader.schemas().end() &&
           (schema->second.data.find("[]") != std::string::npos ||
            schema->second.data.find("[<=") != std::string::npos);
  });
}

/// False: some messages could not be read or shown. Reads twice where the columns are only known at the end.
bool write_table(record::Reader& reader, const record::Query& query, bool names, Table& table) {
  BagMessages texts(reader);
  std::string text;
  bool good = true;
  const auto each_row = [&](const std::function<bool(const Row&)>& f) {
    good = each_message(reader, query, [&](const record::Message& m) {
      const auto row = row_of(m, texts, names, text);
      return !row || f(*row);
    });
  };
  const bool lists = has_lists(reader, query.topics);
  each_row([&](const Row& row) {
    table.add_columns(row);
    return lists;
  });
  each_row([&](const Row& row) {
    table.add(row);
    return true;
  });
  return good && texts.unknown() == 0;
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
    line = to_line({{"topic", m.channel->topic},
                    {"sequence", m.stamps.sequence},
                    {"log_time_ns", m.stamps.log_time},
                    {"stamp_ns", m.stamps.publish_time}});
    line.replace(line.size() - 2, 2, ",\"message\":");  // which comes as text
    const std::size_t message_at = line.size();
    if (!texts.append_json(m, line)) return true;
    if (const auto* schema = texts.schema(*m.channel); options.names && schema) {
      Json message = Json::parse(line.substr(message_at), nullptr, false);
      put_names(message, *schema);
      line.replace(message_at, line.npos, message.dump(-1, ' ', false, Json::error_handler_t::replace));
    }
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
    Table table(out);
    good = write_table(*reader, *query, options.names, table);
    rows = table.rows();
    if ((out == stdout ? std::fflush(out) : std::fclose(out)) != 0)
      return fail(options.out + ": " + std::strerror(errno), kFailed);
  }
  if (options.json && !options.out.empty()) std::printf("%s", to_line({{"file", options.out}, {"rows", rows}}).c_str());
  return good ? kDone : kFailed;
}

}  // namespace sinew::app
