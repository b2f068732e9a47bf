#pragma once
// The image server, without sockets and without a renderer: what a client asks for, and what goes back.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim_hil/usarsim/game.hpp"

namespace sinew::images {
class Encoder;
}

namespace sinew::usarsim {

/// A whole picture (no area), or a part of it.
struct ImageRequest {
  struct Area {
    std::uint32_t x = 0, y = 0, width = 0, height = 0;
  };
  std::optional<Area> area{};
};

/// Pixels of a wall. Shape: height x width x 3, top-left first, without padding.
struct Picture {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb{};
};

/// One client: "OK" asks for a picture, "U" and four big-endian u32 (x, y, width, height) for a part; other bytes are
/// skipped, as real clients send line ends. Each answer is u8 type (0 raw, 1 to 5 JPEG), u32 size, data, big-endian;
/// raw data are u16 width, u16 height and RGB rows, padded to 4 bytes. Source:  robocup-usarsim, ImageServer.cpp.
/// Thread:  owner.
class ImageSession {
 public:
  static constexpr std::size_t kMostRequests = 16;  // more at once are forgotten

  ImageSession(Game& game, std::string address);
  ~ImageSession();
  ImageSession(const ImageSession&) = delete;

  void receive(std::span<const std::byte> bytes);
  /// The next request that has no answer yet, if what was answered before has been sent. Null: there is none.
  const ImageRequest* wanted() const { return requests_.empty() || !waiting().empty() ? nullptr : &requests_.front(); }
  /// What it sees now.
  Wall wall() const { return game_.wall(address_); }
  /// The answer to wanted(). A part that is outside of the picture has none, and is counted.
  void answer(const Picture& picture);

  std::string_view waiting() const { return std::string_view(out_).substr(sent_); }
  void drop_sent(std::size_t bytes) { sent_ = std::min(sent_ + bytes, out_.size()); }

 private:
  void ask(const ImageRequest& request);

  Game& game_;
  std::string address_;
  std::unique_ptr<images::Encoder> encoder_;
  std::vector<ImageRequest> requests_;
  std::string begun_;  // of a request: 'O', or 'U' and up to 15 bytes
  std::string out_;
  std::size_t sent_ = 0;
};

/// Draws one scene at a time, elsewhere.
class Painter {
 public:
  virtual ~Painter() = default;
  virtual bool busy() const = 0;
  /// Begins a picture of tile_width x tile_height in rgb8 into `rgb`, which stays untouched until it is not busy.
  virtual void request(const plant::Scene& scene, std::uint8_t* rgb) = 0;
};

/// Puts the pictures of a wall's cameras together, one after the other.
/// Thread:  owner.
class PictureMaker {
 public:
  PictureMaker(Game& game, Painter& painter) : game_(game), painter_(painter) {}
  bool free() const { return !making_; }
  void begin(const Wall& wall);
  /// The finished picture; null: not yet. Call it often.
  const Picture* poll();

 private:
  bool begin_next();
  void put(const Tile& tile);

  Game& game_;
  Painter& painter_;
  Wall wall_;
  Picture picture_;
  std::vector<std::uint8_t> tile_;
  std::size_t next_ = 0;  // of the wall's tiles; the one before it is being drawn
  bool making_ = false, drawing_ = false;
};

}  // namespace sinew::usarsim
