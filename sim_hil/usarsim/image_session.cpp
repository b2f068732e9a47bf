#include "sim_hil/usarsim/image_session.hpp"

#include <algorithm>

#include "images/encode.hpp"

namespace sinew::usarsim {
namespace {

constexpr std::size_t kAreaBytes = 17;                  // with its U
constexpr int kQualities[] = {0, 100, 75, 50, 25, 10};  // FreeImage's names of JPEG: superb, good, normal, average, bad

void big16(std::string& out, std::uint32_t v) { out += {static_cast<char>(v >> 8 & 255), static_cast<char>(v & 255)}; }
void big32(std::string& out, std::uint32_t v) {
  big16(out, v >> 16);
  big16(out, v & 0xffff);
}
std::uint32_t big32_at(std::string_view bytes, std::size_t at) {
  std::uint32_t v = 0;
  for (std::size_t i = 0; i < 4; ++i) v = v << 8 | static_cast<unsigned char>(bytes[at + i]);
  return v;
}

/// The part that is in the picture.
ImageRequest::Area clipped(const std::optional<ImageRequest::Area>& wanted, const Picture& picture) {
  if (!wanted) return {0, 0, picture.width, picture.height};
  ImageRequest::Area a = *wanted;
  if (a.x >= picture.width || a.y >= picture.height) return {};
  a.width = std::min(a.width, picture.width - a.x);
  a.height = std::min(a.height, picture.height - a.y);
  return a;
}

void write_raw(const Picture& picture, const ImageRequest::Area& area, std::string& out) {
  big16(out, area.width);
  big16(out, area.height);
  const std::size_t row = std::size_t{area.width} * 3, padding = (4 - row % 4) % 4;
  for (std::uint32_t y = area.y; y < area.y + area.height; ++y) {
    const std::uint8_t* from = picture.rgb.data() + (std::size_t{y} * picture.width + area.x) * 3;
    out.append(reinterpret_cast<const char*>(from), row);
    out.append(padding, '\0');
  }
}

}  // namespace

ImageSession::ImageSession(Game& game, std::string address)
    : game_(game), address_(std::move(address)), encoder_(std::make_unique<images::Encoder>()) {
  ++game_.counts().image_clients;
  if (game_.options().legacy) ask({});
}

ImageSession::~ImageSession() = default;

void ImageSession::ask(const ImageRequest& request) {
  if (requests_.size() < kMostRequests) requests_.push_back(request);
}

void ImageSession::receive(std::span<const std::byte> bytes) {
  for (const std::byte byte : bytes) {
    const char c = static_cast<char>(byte);
    if (begun_ == "O") {
      begun_.clear();
      if (c == 'K')
        ask({});
      else
        game_.counts().skipped += 2;
      continue;
    }
    if (begun_.empty()) {
      if (c == 'O' || c == 'U')
        begun_ = c;
      else if (c != '\r' && c != '\n')
        ++game_.counts().skipped;
      continue;
    }
    begun_ += c;
    if (begun_.size() < kAreaBytes) continue;
    ask({ImageRequest::Area{big32_at(begun_, 1), big32_at(begun_, 5), big32_at(begun_, 9), big32_at(begun_, 13)}});
    begun_.clear();
  }
}

void ImageSession::answer(const Picture& picture) {
  if (requests_.empty()) return;
  const ImageRequest::Area area = clipped(requests_.front().area, picture);
  requests_.erase(requests_.begin());
  if (area.width == 0 || area.height == 0) {
    ++game_.counts().unusable;
    return;
  }
  out_.clear();
  sent_ = 0;
  std::string data;
  int type = game_.options().image_type;
  if (type != 0) {
    const images::PixelView view{picture.rgb, picture.width, picture.height, picture.width * 3, msg::PixelFormat::rgb8};
    const auto file = encoder_->encode(view, images::Kind::jpeg, {area.x, area.y, area.width, area.height},
                                       {.quality = kQualities[std::clamp(type, 1, 5)]});
    if (file)
      data.assign(reinterpret_cast<const char*>(file->data()), file->size());
    else
      type = 0;  // a build without JPEG
  }
  if (type == 0) write_raw(picture, area, data);
  out_ += static_cast<char>(type);
  big32(out_, static_cast<std::uint32_t>(data.size()));
  out_ += data;
  ++game_.counts().frames;
}

// ---- pictures

void PictureMaker::begin(const Wall& wall) {
  wall_ = wall;
  picture_.width = wall.width, picture_.height = wall.height;
  picture_.rgb.assign(std::size_t{wall.width} * wall.height * 3, 0);
  next_ = 0;
  making_ = true;
  drawing_ = begin_next();
}

/// False: no camera is left.
bool PictureMaker::begin_next() {
  const Options& o = game_.options();
  tile_.resize(std::size_t{o.tile_width} * o.tile_height * 3);
  for (; next_ < wall_.tiles.size(); ++next_) {
    const std::size_t slot = wall_.tiles[next_].slot;
    const plant::Vehicle* v = slot < plant::kMostRobots ? game_.place().vehicle(slot) : nullptr;
    if (!v) continue;  // black: none is chosen, or it is gone
    painter_.request(v->scene(0), tile_.data());
    ++next_;
    return true;
  }
  return false;
}

void PictureMaker::put(const Tile& tile) {
  const Options& o = game_.options();
  const std::size_t row = std::size_t{o.tile_width} * 3;
  for (std::uint32_t y = 0; y < o.tile_height; ++y)
    std::copy_n(tile_.data() + y * row, row,
                picture_.rgb.data() + (std::size_t{tile.y + y} * picture_.width + tile.x) * 3);
}

const Picture* PictureMaker::poll() {
  if (!making_ || (drawing_ && painter_.busy())) return nullptr;
  if (drawing_) {
    put(wall_.tiles[next_ - 1]);
    drawing_ = begin_next();
    if (drawing_) return nullptr;
  }
  making_ = false;
  return &picture_;
}

}  // namespace sinew::usarsim
