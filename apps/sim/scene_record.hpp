#pragma once
// A file of all scenes of a run: where every body was when a picture was taken, by which camera, and the world that
// they are in. MCAP; docs/recording.md describes it.
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "record/reader.hpp"
#include "record/writer.hpp"
#include "sim_hil/plant/session_options.hpp"

namespace sinew::plant {

struct SimulatorOptions;

/// What the pictures depend on besides the scenes.
struct SceneWorld {
  std::vector<std::string> words;             // of sinew-sim's command line, without those about connections and files
  std::map<std::string, std::string> bodies;  // text of each body's file, by robot; "" for all of them
};
SceneWorld scene_world_of(const SimulatorOptions& options);

/// All pictures of one instant.
struct TakenScene {
  struct Picture {
    std::size_t robot = 0, camera = 0;
    std::uint32_t number = 0;
    CameraPose pose{};
  };
  hal::Time at{};
  std::vector<Pose> bodies{};
  std::vector<Picture> pictures{};

  /// As the painter of the world takes it.
  Scene scene(const CameraPose& camera) const;
};

/// Thread:  the session's. A failed write is reported by finish().
class SceneRecord final : public SceneSink {
 public:
  /// Errors:  null, with `why`: there is such a file already, the disk.
  static std::unique_ptr<SceneRecord> open(const std::string& path, const SceneWorld& world, std::string& why);
  void picture(std::size_t robot, std::size_t camera, std::uint32_t number, hal::Time at, const Scene& scene) override;
  /// Completes the file. Errors: false, with `why`.
  bool finish(std::string& why);

 private:
  explicit SceneRecord(std::unique_ptr<record::Writer> writer) : writer_(std::move(writer)) {}
  hal::Status add_channel();
  void write();

  std::unique_ptr<record::Writer> writer_;
  std::uint16_t channel_ = 0;
  std::uint32_t sequence_ = 0;
  TakenScene taken_;
  record::Buffer bytes_;
  hal::Status trouble_;
};

/// Reads such a file.
class SceneFile {
 public:
  /// Errors:  null, with `why`: it cannot be read, or holds no scenes.
  static std::unique_ptr<SceneFile> open(const std::string& path, std::string& why);
  const SceneWorld& world() const { return world_; }
  /// The next one; nothing: the end, or a problem, which `why` then says.
  std::optional<TakenScene> next(std::string& why);

 private:
  explicit SceneFile(std::unique_ptr<record::Reader> reader) : reader_(std::move(reader)) {}
  std::unique_ptr<record::Reader> reader_;
  std::optional<record::MessageReader> messages_;
  SceneWorld world_;
};

/// The content of a message. Errors: nothing for bytes that are none.
void encode(record::Buffer& to, const TakenScene& scene);
std::optional<TakenScene> decode_scene(std::span<const std::byte> bytes);

}  // namespace sinew::plant
