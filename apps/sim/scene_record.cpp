#include "apps/sim/scene_record.hpp"

#include <algorithm>
#include <bit>
#include <cstdio>

#include "apps/sim/sim_options.hpp"
#include "apps/toml/body_reader.hpp"
#include "hal/linux/file.hpp"

namespace sinew::plant {
namespace {

constexpr const char* kTopic = "scene";
constexpr const char* kMetadata = "sinew.scenes";
constexpr std::string_view kBodyFile = "body", kBodyEnding = ".toml";
constexpr std::uint32_t kEncapsulation = 0x100;                     // XCDR1, little-endian
constexpr std::size_t kPerBody = 7, kPerPicture = 3, kPerView = 8;  // numbers

// ros2msg, so that other programs can read it.
constexpr const char* kSchema = R"(# Where all bodies were when pictures were taken.
int64 stamp          # ns, of the world's clock
float64[] bodies     # of each: x y z in m, quaternion w x y z to the world; in the order of the world's painter
int64[] pictures     # of each: robot, camera, number, from 0, 0 and 1
float64[] views      # of each picture: focal length as a share of its height, x y z, quaternion w x y z (optical)
)";

/// Words about connections and files, and how many more words each has when it does not hold a "=".
struct Left {
  std::string_view option;
  bool has_value = true;
};
constexpr Left kLeft[] = {{"--listen"},          {"--report"},      {"--scenes"},  {"--body"},
                          {"--fault"},           {"--duration"},    {"--wait"},    {"--relink"},
                          {"--lockstep", false}, {"--free", false}, {"--priority"}};

void put_number(record::Buffer& to, double value) { to.number(std::bit_cast<std::uint64_t>(value)); }
double number(record::Cursor& from) { return std::bit_cast<double>(from.number<std::uint64_t>()); }

/// The length of a sequence of numbers of 8 bytes, which begin at a multiple of 8 behind the encapsulation (XCDR1).
void put_length(record::Buffer& to, std::size_t n) {
  to.number(static_cast<std::uint32_t>(n));
  to.number(std::uint32_t{0});
}
std::size_t length(record::Cursor& from) {
  const auto n = from.number<std::uint32_t>();
  static_cast<void>(from.number<std::uint32_t>());
  if (n <= from.rest().size() / 8) return n;
  static_cast<void>(from.take(~std::uint64_t{0}));
  return 0;
}

void put(record::Buffer& to, const msg::Vec3& p, const msg::Quat& q) {
  for (const double v : {p.x, p.y, p.z, q.w, q.x, q.y, q.z}) put_number(to, v);
}
void read(record::Cursor& from, msg::Vec3& p, msg::Quat& q) {
  for (double* const v : {&p.x, &p.y, &p.z, &q.w, &q.x, &q.y, &q.z}) *v = number(from);
}

std::string text_of(const hal::Error& e) { return std::string(hal::to_string(e.code)) + " (" + e.where + ")"; }

std::string numbered(std::size_t i) {
  char key[32];
  std::snprintf(key, sizeof key, "argument %04zu", i);
  return key;
}

}  // namespace

SceneWorld scene_world_of(const SimulatorOptions& options) {
  SceneWorld world;
  for (std::size_t i = 0; i < options.words.size(); ++i) {
    const std::string_view word = options.words[i];
    const auto left = std::ranges::find_if(kLeft, [&](const Left& l) {
      return word == l.option ||
             (word.starts_with(l.option) && word.size() > l.option.size() && word[l.option.size()] == '=');
    });
    if (left == std::end(kLeft))
      world.words.emplace_back(word);
    else if (left->has_value && word == left->option)
      ++i;
  }
  for (const std::string& body : options.bodies) {
    std::string robot;
    for (const NamedRobot& r : options.session.world.robots)
      if (body.starts_with(r.name + "=")) robot = r.name;
    if (const auto text = app::body_text(robot.empty() ? body : body.substr(robot.size() + 1)))
      world.bodies[robot] = *text;
  }
  return world;
}

Scene TakenScene::scene(const CameraPose& camera) const {
  Scene scene;
  scene.camera = camera;
  scene.bodies = std::min(bodies.size(), Scene::kMost);
  std::copy_n(bodies.begin(), scene.bodies, scene.body.begin());
  return scene;
}

void encode(record::Buffer& to, const TakenScene& scene) {
  to.clear();
  to.number(kEncapsulation);
  to.number(static_cast<std::uint64_t>(scene.at.ns));
  put_length(to, kPerBody * scene.bodies.size());
  for (const Pose& body : scene.bodies) put(to, body.p_world_m, body.q_world);
  put_length(to, kPerPicture * scene.pictures.size());
  for (const auto& p : scene.pictures)
    for (const std::uint64_t v : {std::uint64_t{p.robot}, std::uint64_t{p.camera}, std::uint64_t{p.number}})
      to.number(v);
  put_length(to, kPerView * scene.pictures.size());
  for (const auto& p : scene.pictures) {
    put_number(to, p.pose.focal_per_height);
    put(to, p.pose.p_world_m, p.pose.q_world_optical);
  }
}

std::optional<TakenScene> decode_scene(std::span<const std::byte> bytes) {
  record::Cursor from(bytes);
  if (from.number<std::uint32_t>() != kEncapsulation) return std::nullopt;
  TakenScene scene;
  scene.at.ns = static_cast<std::int64_t>(from.number<std::uint64_t>());
  scene.bodies.resize(length(from) / kPerBody);
  for (Pose& body : scene.bodies) read(from, body.p_world_m, body.q_world);
  scene.pictures.resize(length(from) / kPerPicture);
  for (auto& p : scene.pictures) {
    p.robot = static_cast<std::size_t>(from.number<std::uint64_t>());
    p.camera = static_cast<std::size_t>(from.number<std::uint64_t>());
    p.number = static_cast<std::uint32_t>(from.number<std::uint64_t>());
  }
  if (length(from) != kPerView * scene.pictures.size()) return std::nullopt;
  for (auto& p : scene.pictures) {
    p.pose.focal_per_height = number(from);
    read(from, p.pose.p_world_m, p.pose.q_world_optical);
  }
  return from.good() && from.rest().empty() ? std::optional(std::move(scene)) : std::nullopt;
}

std::unique_ptr<SceneRecord> SceneRecord::open(const std::string& path, const SceneWorld& world, std::string& why) {
  auto file = hal::create_file(path);
  if (!file) return why = text_of(file.error()), nullptr;
  auto writer = record::Writer::open(std::move(*file), {.compression = record::Compression::zstd});
  if (!writer) return why = text_of(writer.error()), nullptr;
  std::unique_ptr<SceneRecord> made(new SceneRecord(std::move(*writer)));
  record::Writer& w = *made->writer_;
  record::Metadata about{kMetadata, {}};
  for (std::size_t i = 0; i < world.words.size(); ++i) about.values[numbered(i)] = world.words[i];
  hal::Status done = w.add_metadata(about);
  for (const auto& [robot, text] : world.bodies)
    if (done)
      done = w.attach({0, 0, std::string(kBodyFile) + robot + std::string(kBodyEnding), "application/toml", text});
  if (done) done = made->add_channel();
  if (!done) return why = text_of(done.error()), nullptr;
  return made;
}

hal::Status SceneRecord::add_channel() {
  const auto schema = writer_->add_schema("sinew_msgs/msg/Scene", "ros2msg", kSchema);
  if (!schema) return schema.error();
  const auto channel = writer_->add_channel(kTopic, "cdr", *schema);
  if (!channel) return channel.error();
  channel_ = *channel;
  return {};
}

void SceneRecord::picture(std::size_t robot, std::size_t camera, std::uint32_t number, hal::Time at,
                          const Scene& scene) {
  if (!taken_.pictures.empty() && taken_.at != at) write();
  if (taken_.pictures.empty()) {
    taken_.at = at;
    taken_.bodies.assign(scene.body.begin(), scene.body.begin() + static_cast<std::ptrdiff_t>(scene.bodies));
  }
  taken_.pictures.push_back({robot, camera, number, scene.camera});
}

void SceneRecord::write() {
  if (taken_.pictures.empty()) return;
  encode(bytes_, taken_);
  const auto at = static_cast<std::uint64_t>(taken_.at.ns);
  if (const hal::Status written = writer_->write(channel_, {sequence_++, at, at}, bytes_.bytes()); !written)
    trouble_ = written;
  taken_.pictures.clear();
}

bool SceneRecord::finish(std::string& why) {
  write();
  if (const hal::Status finished = writer_->finish(); trouble_ && !finished) trouble_ = finished;
  if (trouble_) return true;
  why = text_of(trouble_.error());
  return false;
}

std::unique_ptr<SceneFile> SceneFile::open(const std::string& path, std::string& why) {
  auto file = hal::open_file(path);
  if (!file) return why = text_of(file.error()), nullptr;
  record::FileProblem problem;
  auto reader = record::Reader::open(std::move(*file), problem);
  if (!reader) return why = record::to_string(problem), nullptr;
  std::unique_ptr<SceneFile> opened(new SceneFile(std::move(reader)));
  for (auto& [key, word] : record::read_metadata(*opened->reader_, kMetadata)) opened->world_.words.push_back(word);
  if (opened->world_.words.empty()) return why = "the file holds no scenes of sinew-sim", nullptr;
  for (const auto& index : opened->reader_->attachments()) {
    const std::string_view name = index.name;
    if (!name.starts_with(kBodyFile) || !name.ends_with(kBodyEnding)) continue;
    const auto text = record::read_attachment(*opened->reader_, name);
    if (!text) return why = index.name + " in it cannot be read", nullptr;
    opened->world_
        .bodies[std::string(name.substr(kBodyFile.size(), name.size() - kBodyFile.size() - kBodyEnding.size()))] =
        *text;
  }
  opened->messages_.emplace(opened->reader_->messages({.topics = {kTopic}, .order = record::Order::file}));
  return opened;
}

std::optional<TakenScene> SceneFile::next(std::string& why) {
  record::Message m;
  const record::Next next = messages_->next(m);
  if (next == record::Next::end) return std::nullopt;
  if (next == record::Next::problem) return why = record::to_string(messages_->problem()), std::nullopt;
  auto scene = decode_scene(m.data);
  if (!scene) why = "a message of it is no scene";
  return scene;
}

}  // namespace sinew::plant
