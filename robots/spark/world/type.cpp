// The world "simspark", for the list of worlds.
#include <cstdio>

#include "robots/spark/world/spark_plant.hpp"

namespace sinew::robots {

plant::WorldType describe_world_of_spark();

}  // namespace sinew::robots

namespace sinew::plant {

std::shared_ptr<const WorldType> spark_world_in(const WorldType& type, SparkServer server) {
  auto bound = std::make_shared<WorldType>(type);
  bound->create = [server = std::move(server)](const WorldChoice& choice,
                                               std::uint64_t) -> hal::Result<std::unique_ptr<World>> {
    std::string why;
    auto made = SparkPlant::create(choice, server, why);
    if (made) return std::unique_ptr<World>(std::move(*made));
    std::fprintf(stderr, "sinew-sim: simspark: %s\n", why.c_str());
    return made.error();
  };
  return bound;
}

}  // namespace sinew::plant

sinew::plant::WorldType sinew::robots::describe_world_of_spark() {
  using namespace plant;
  WorldType type;
  type.info = SparkPlant::info();
  type.title = "a player in a server of SimSpark";
  type.create = [](const WorldChoice&, std::uint64_t) -> hal::Result<std::unique_ptr<World>> {
    return hal::Error{hal::Errc::bad_argument, "simspark: no server"};
  };
  return type;
}
