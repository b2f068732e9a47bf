#include "apps/sim/usarsim_serve.hpp"

#include <cstdio>

#include "hal/linux/process.hpp"
#include "hal/linux/socket.hpp"
#include "hal/platform.hpp"
#include "sim_hil/plant/camera_feed.hpp"
#include "sim_hil/usarsim/server.hpp"
#include "sim_hil/worlds/json_object.hpp"
#include "sim_hil/worlds/verdict_json.hpp"

namespace sinew::plant {
namespace {

int usarsim_failed(const std::string& what, const hal::Error& error) {
  std::fprintf(stderr, "sinew-sim: %s: %s (%s, %lld)\n", what.c_str(), hal::to_string(error.code), error.where,
               static_cast<long long>(error.detail));
  return 1;
}

/// The renderer's thread as the door wants it.
class FeedPainter final : public usarsim::Painter {
 public:
  explicit FeedPainter(CameraFeed& feed) : feed_(feed) {}
  bool busy() const override { return feed_.busy(); }
  void request(const Scene& scene, std::uint8_t* rgb) override { feed_.request(scene, ++number_, rgb); }

 private:
  CameraFeed& feed_;
  std::uint32_t number_ = 0;
};

void print_counts(const usarsim::Counts& c, double plant_s, std::uint64_t late) {
  const auto n = [](std::uint64_t count) { return static_cast<unsigned long long>(count); };
  std::printf("ended after %.2f s of plant time; the clock was late %llu times\n", plant_s, n(late));
  std::printf("%llu connections, %llu robots, %llu refused; %llu lines came, %llu were sent, %llu found no reader\n",
              n(c.connections), n(c.robots), n(c.refused), n(c.lines), n(c.sent), n(c.unsent));
  std::printf("%llu image clients, %llu pictures, %llu bytes skipped\n", n(c.image_clients), n(c.frames), n(c.skipped));
  std::printf("not obeyed: %llu dropped, %llu torn, %llu without what their type needs, %llu of unknown type",
              n(c.dropped), n(c.torn), n(c.unusable), n(c.unknown));
  for (const auto& [type, count] : c.of_type) std::printf(", %s: %llu", type.c_str(), n(count));
  std::printf("\n");
}

std::string visit_json(const usarsim::Game::Visit& v) {
  JsonObject j;
  j.text("name", v.name);
  j.text("class", v.kind->name);
  const std::pair<const char*, double> numbers[] = {
      {"from_s", v.from_s},       {"until_s", v.until_s},   {"driven_m", v.driven_m},
      {"highest_m", v.highest_m}, {"from_x_m", v.from_m.x}, {"from_y_m", v.from_m.y},
      {"to_x_m", v.to_m.x},       {"to_y_m", v.to_m.y},     {"to_z_m", v.to_m.z}};
  for (const auto& [key, value] : numbers) j.number(key, value);
  j.integer("touches", v.touches);
  j.integer("drives", v.drives);
  j.boolean("stands", v.stands);
  j.object("verdict", verdict_json(v.verdict));
  return j.done();
}

std::string counts_json(const char* world, const usarsim::Game& game, std::uint64_t late) {
  const usarsim::Counts& c = game.counts();
  const Place& place = game.place();
  JsonObject types, all;
  std::vector<std::string> visits;
  for (const auto& visit : game.visits()) visits.push_back(visit_json(visit));
  for (const auto& [type, count] : c.of_type) types.integer(type.c_str(), count);
  all.text("world", world);
  all.text("place", place.map().name);
  all.number("plant_s", msg::seconds(place.now()));
  all.integer("clock_late", late);
  const std::pair<const char*, std::uint64_t> numbers[] = {{"connections", c.connections},
                                                           {"robots", c.robots},
                                                           {"refused", c.refused},
                                                           {"lines", c.lines},
                                                           {"dropped", c.dropped},
                                                           {"torn", c.torn},
                                                           {"unknown", c.unknown},
                                                           {"unusable", c.unusable},
                                                           {"sent", c.sent},
                                                           {"unsent", c.unsent},
                                                           {"frames", c.frames},
                                                           {"image_clients", c.image_clients},
                                                           {"skipped", c.skipped}};
  for (const auto& [key, value] : numbers) all.integer(key, value);
  all.object("unknown_types", types.done());
  all.list("robots_gone", visits);
  return all.done();
}

}  // namespace

int serve_usarsim(const SimulatorOptions& s, std::string& report) {
  static_cast<void>(hal::stop_requested());  // from here on a signal only asks for the end
  hal::Os& os = hal::system_os();
  auto world = s.session.world.create(s.session.seed.value_or(1));
  if (!world) return usarsim_failed("the world could not be made", world.error());
  auto* place = dynamic_cast<Place*>(world->get());
  if (!place) {
    std::fprintf(stderr, "sinew-sim: --serve usarsim: the world %s is no place that robots enter; %s is\n",
                 s.session.world.type->info.name, UsarsimOptions::kWorld);
    return kUsage;
  }
  for (std::size_t slot = 0; slot < kMostRobots; ++slot) place->leave(slot);  // clients bring the robots
  usarsim::Game game(*place, s.usarsim.door(s.view.width, s.view.height));
  usarsim::Server::Doors doors;
  auto text = hal::listen_stream(s.listen);
  if (!text) return usarsim_failed("cannot listen on " + s.listen, text.error());
  auto images = hal::listen_stream(s.usarsim.image_listen);
  if (!images) return usarsim_failed("cannot listen on " + s.usarsim.image_listen, images.error());
  doors.text = std::move(*text), doors.images = std::move(*images);
  doors.address = hal::peer_address;
  CameraOptions view = s.view;
  view.format = msg::PixelFormat::rgb8;
  std::string why;
  auto feed = CameraFeed::start(os, view, why);
  if (!feed) return usarsim_failed("no camera: " + why, feed.error());
  FeedPainter painter(**feed);
  std::printf("%s as USARSim: listening on %s, pictures on %s, drawn by %s\n", place->map().name.c_str(),
              doors.text->endpoint().c_str(), doors.images->endpoint().c_str(), (*feed)->backend().c_str());
  std::fflush(stdout);
  usarsim::Server server(os, game, std::move(doors), &painter);
  const std::uint64_t late = server.run(s.session.duration_s, &hal::stop_requested);
  server.close();
  for (const auto& v : game.visits())
    std::printf(
        "%s (%s), %.1f to %.1f s: %.1f m, at most %.2f m high, touched something %u times; %s at %.2f, %.2f, %.2f\n",
        v.name.c_str(), v.kind->name, v.from_s, v.until_s, v.driven_m, v.highest_m, v.touches,
        v.stands ? "it stood" : "it flew", v.to_m.x, v.to_m.y, v.to_m.z);
  print_counts(game.counts(), game.now_s(), late);
  report = counts_json(s.session.world.type->info.name, game, late);
  return 0;
}

}  // namespace sinew::plant
