// For any bytes, of two text clients and an image client that take turns: the place stays finite, answers are lines
// that the codec reads, memory is bounded. The first byte of a piece says whose it is and how much time passes behind
// it, the second how long it is.
#include <cstdlib>

#include "sim_hil/usarsim/image_session.hpp"
#include "sim_hil/usarsim/session.hpp"

using namespace sinew;

namespace {

plant::PlaceMap small_map() {
  plant::PlaceMap map;
  map.name = "Fuzz";
  map.solids.push_back({plant::Shape::plane, {}, {}, {}});
  map.solids.push_back({plant::Shape::box, {3, 0, 0.5}, {}, {0.5, 1, 0.5}});
  map.starts = {{"Pose1", {0, 0, 0}, 0}, {"Pose2", {0, 2, 0}, 1}};
  map.target_way = {{1, 1, 0.25}, {1, 2, 0.25}};
  return map;
}

void check_lines(usarsim::Session& session) {
  static wire::UsarLine line;
  const std::string_view all = session.waiting();
  if (all.size() > usarsim::Session::kMostWaiting) std::abort();
  for (std::size_t at = 0; at < all.size();) {
    const auto end = all.find("\r\n", at);
    if (end == std::string_view::npos) std::abort();
    if (wire::parse_usarsim(all.substr(at, end - at), line) == wire::UsarError::brace) std::abort();
    at = end + 2;
  }
  session.drop_sent(all.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  plant::Place place(small_map(), {1, 0.5, true});
  usarsim::Options options;
  options.image_type = 0;
  options.tile_width = 16, options.tile_height = 12;
  usarsim::Game game(place, options);
  auto first = std::make_unique<usarsim::Session>(game, "1", 1),
       second = std::make_unique<usarsim::Session>(game, "2", 2);
  usarsim::ImageSession images(game, "1");
  constexpr std::size_t kMostPieces = 64;
  std::size_t pieces = 0;
  for (std::size_t at = 0; at + 2 <= size && pieces < kMostPieces; ++pieces) {
    const std::uint8_t whose = data[at], length = data[at + 1];
    at += 2;
    const auto bytes = std::as_bytes(std::span(data + at, std::min<std::size_t>(length, size - at)));
    at += bytes.size();
    if (whose % 4 == 0) second->receive(bytes);
    if (whose % 4 == 1) images.receive(bytes);
    if (whose % 4 >= 2) first->receive(bytes);
    for (int i = 0; i < (whose >> 2) * 4; ++i) place.advance({});
    first->tick();
    second->tick();
    check_lines(*first);
    check_lines(*second);
    while (images.wanted()) {
      const usarsim::Wall wall = images.wall();
      if (wall.width > 4 * options.tile_width || wall.height > 4 * options.tile_height) std::abort();
      images.answer({wall.width, wall.height, std::vector<std::uint8_t>(std::size_t{wall.width} * wall.height * 3)});
      if (images.waiting().size() > 9 + std::size_t{wall.width} * wall.height * 4) std::abort();
      images.drop_sent(images.waiting().size());
    }
    for (std::size_t slot = 0; slot < plant::kMostRobots; ++slot)
      if (const plant::Vehicle* v = place.vehicle(slot); v && !math::is_finite(v->body().p_world_m)) std::abort();
    if (place.things().size() > std::size(plant::kThingKinds) * plant::kMostOfAKind) std::abort();
    if (whose == 255) {
      first.reset();
      first = std::make_unique<usarsim::Session>(game, "1", 3);
    }
  }
  first.reset();
  second.reset();
  if (place.robots() != 0) std::abort();
  return 0;
}
