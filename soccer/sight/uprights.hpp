#pragma once
// What stands on the carpet: posts of goals, and robots.
#include <array>
#include <span>

#include "soccer/sight/field_border.hpp"

namespace sinew::soccer {

/// Columns in which something that is no carpet comes down over the border. A post: columns with an edge at a post's
/// width on both sides, up to its height. A robot: neighbouring columns that are dark or of a jersey's colour.
/// Units:   as seen. `feet`: where the lowest pixels are on the ground.
/// Thread:  owner.   RT: yes.
class Uprights {
 public:
  struct Thing {
    GroundXy feet;
    double u0_px = 0, u1_px = 0, foot_px = 0;  // its columns, and the row of its foot
    double wide_m = 0, px_per_m = 0;
    double dark = 0, blue = 0, red = 0;  // shares of its pixels
    bool is_post = false;
    bool is_cut = false;  // its foot is below the picture: only while things are put together
    double confidence = 0;
  };
  static constexpr std::size_t kMost = 16;
  void find(const Picture& picture, const GroundView& view, const FieldBorder& border, const CarpetLook& carpet);
  std::span<const Thing> things() const { return {thing_.data(), count_}; }

 private:
  void find_posts(const Picture& picture, const GroundView& view, const FieldBorder& border, std::span<int> foot,
                  int pitch);
  void add(const Picture& picture, const GroundView& view, const FieldBorder& border, int x0, int x1, int foot);

  std::array<Thing, kMost> thing_{};
  std::size_t count_ = 0;
  int darker_ = 0;  // luma below which what is no carpet is no line
};

}  // namespace sinew::soccer
