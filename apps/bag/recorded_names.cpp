#include "apps/bag/recorded_names.hpp"

#include <algorithm>

#include "apps/command/command.hpp"
#include "hal/linux/file.hpp"
#include "record/reader.hpp"
#include "record/ros2_schema.hpp"

namespace sinew::app {
namespace {

void add_fields(const record::Ros2Schema& schema, const record::Ros2Schema::Type& type, const std::string& path,
                std::vector<std::string>& names) {
  for (const record::Ros2Field& field : type.fields) {
    const std::string name = path.empty() ? field.name : path + "." + field.name;
    names.push_back(name);
    if (field.kind == record::Ros2Field::Kind::nested && field.shape == record::Ros2Field::Shape::one)
      add_fields(schema, schema.type(field), name, names);
  }
}

void add_fields(const record::Reader& reader, const record::Channel& channel, const std::string& path,
                std::vector<std::string>& names) {
  const auto from = reader.schemas().find(channel.schema);
  if (from == reader.schemas().end()) return;
  std::string why;
  if (const auto schema = record::Ros2Schema::parse(from->second.name, from->second.data, why))
    add_fields(*schema, schema->root(), path, names);
}

}  // namespace

std::vector<std::string> recorded_names(std::string_view hint, const std::string& file, const std::string& topic) {
  auto input = hal::open_file(file);
  if (!input) return {};
  record::FileProblem why;
  const auto reader = record::Reader::open(std::move(*input), why);
  if (!reader) return {};
  std::vector<std::string> names;
  if (hint == kModuleHint)
    for (const auto& [number, name] : record::read_metadata(*reader, "sinew.modules")) names.push_back(name);
  for (const auto& [id, channel] : reader->channels()) {
    if (hint == kTopicHint) names.push_back(channel.topic);
    if (hint == kFieldHint && (topic.empty() || channel.topic == topic))
      add_fields(*reader, channel, topic.empty() ? channel.topic : "", names);
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace sinew::app
