#include "apps/sim/usarsim_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "apps/command/choice_check.hpp"

namespace sinew::plant {
namespace {

/// In the order of the image server's types.
const std::vector<std::string>& image_types() {
  static const std::vector<std::string> all{"raw", "superb", "good", "normal", "average", "bad"};
  return all;
}

constexpr const char* kUsarsimOptions[] = {"--image-listen", "--image-type", "--sonar", "--right-hand",
                                           "--legacy-images"};

}  // namespace

void UsarsimOptions::describe(CLI::App& app) {
  app.add_option("--image-listen", image_listen, "usarsim: where pictures are served: tcp:HOST:PORT")
      ->capture_default_str();
  app.add_option("--image-type", image_type, "usarsim: how pictures are sent: raw, or a JPEG of this quality")
      ->check(app::one_of(image_types()))
      ->capture_default_str();
  app.add_option("--sonar", sonar, "usarsim: all sonars together in one brace (UT2004), or each in its line (UDK)")
      ->check(app::one_of({"together", "apart"}))
      ->capture_default_str();
  app.add_flag("--right-hand", right_hand, "usarsim: z points down, as UDK's setting RightHand has it");
  app.add_flag("--legacy-images", legacy_images, "usarsim: a picture goes to an image client before it asks");
}

const char* UsarsimOptions::given(const CLI::App& app) {
  const auto found = std::ranges::find_if(kUsarsimOptions, [&](const char* o) { return app.count(o) > 0; });
  return found == std::end(kUsarsimOptions) ? nullptr : *found;
}

usarsim::Options UsarsimOptions::door(std::uint32_t width, std::uint32_t height) const {
  usarsim::Options o;
  o.sonars_together = sonar == "together";
  o.frame.z_down = right_hand;
  o.tile_width = width, o.tile_height = height;
  o.image_type = static_cast<int>(std::ranges::find(image_types(), image_type) - image_types().begin());
  o.legacy = legacy_images;
  return o;
}

}  // namespace sinew::plant
