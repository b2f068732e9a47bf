#include "client/topics.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "msg/text.hpp"

namespace sinew::client {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxFields = 4096;
constexpr int kMaxDepth = 8;

std::optional<msg::Kind> kind_of(std::string_view name) {
  constexpr std::array<std::string_view, 10> kNames{"i8",  "u8",  "i16", "u16", "i32",
                                                    "u32", "i64", "u64", "f32", "f64"};  // in the order of msg::Kind
  const auto at = std::find(kNames.begin(), kNames.end(), name);
  if (at == kNames.end()) return std::nullopt;
  return static_cast<msg::Kind>(at - kNames.begin());
}

/// Throws Json::exception where the reply lacks a member; answers false where the members make no sense.
class FieldList {
 public:
  FieldList(const Json& types, std::uint32_t message_bytes) : types_(types), message_bytes_(message_bytes) {}

  bool add(const std::string& type, const std::string& prefix, std::uint64_t base, int depth) {
    if (depth > kMaxDepth) return false;
    for (const Json& f : types_.at(type).at("fields"))
      if (!add_field(f, prefix, base, depth)) return false;
    return true;
  }
  std::vector<Field> take() { return std::move(fields_); }

 private:
  bool add_field(const Json& f, const std::string& prefix, std::uint64_t base, int depth) {
    const std::string type = f.at("type").get<std::string>();
    const std::string name = prefix + f.at("name").get<std::string>();
    const std::uint64_t offset = base + f.at("offset").get<std::uint32_t>();
    const auto count = f.at("count").get<std::uint32_t>();
    const bool is_array = f.at("array").get<bool>();
    if (const auto kind = kind_of(type)) {
      if (count == 0 || offset + std::uint64_t{count} * msg::size_of(*kind) > message_bytes_) return false;
      const std::string names = f.contains("names") ? f["names"].dump() : "";
      fields_.push_back({name, f.at("unit").get<std::string>(), f.at("doc").get<std::string>(), names, *kind,
                         static_cast<std::uint32_t>(offset), count, is_array});
      return fields_.size() <= kMaxFields;
    }
    const auto bytes = types_.at(type).at("bytes").get<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::string index = is_array ? "[" + std::to_string(i) + "]" : "";
      if (!add(type, name + index + ".", offset + std::uint64_t{i} * bytes, depth + 1)) return false;
    }
    return true;
  }

  const Json& types_;
  std::uint32_t message_bytes_;
  std::vector<Field> fields_;
};

}  // namespace

hal::Result<std::vector<Topic>> describe_topics(std::string_view reply, const tap::SegmentReader& reader) {
  const hal::Error wrong{hal::Errc::bad_data, "the robot's list of topics"};
  std::vector<Topic> topics(reader.topics().size());
  try {
    const Json json = Json::parse(reply);
    for (const Json& t : json.at("topics")) {
      const auto name = t.at("name").get<std::string>();
      const auto index = reader.find(name);
      if (!index) continue;
      Topic& topic = topics[*index];
      FieldList fields(json.at("types"), reader.topics()[*index].message_bytes);
      topic.name = name;
      topic.type = t.at("type").get<std::string>();
      topic.external = t.value("external", false);
      topic.wakes_outsiders = t.value("wakes_outsiders", false);
      topic.rate_hz = t.at("rate_hz").get<double>();
      if (!fields.add(topic.type, "", 0, 0)) return wrong;
      topic.fields = fields.take();
    }
  } catch (const Json::exception&) {
    return wrong;
  }
  for (const Topic& t : topics)
    if (t.name.empty()) return wrong;
  return topics;
}

}  // namespace sinew::client
