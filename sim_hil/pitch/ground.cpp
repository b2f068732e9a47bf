#include "sim_hil/pitch/ground.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>

#include "math/linear.hpp"
#include "sim_hil/pitch/model.hpp"

namespace sinew::plant {
namespace {

using math::Vec3;

constexpr int kMostContacts = 8;          // of one shape: the deepest
constexpr double kFaceLooksDown = 0.3;    // cosine: faces steeper than that are not held up by a point under them
constexpr double kAlongCapsule_m = 0.03;  // between two points of its axis

mjfCollision mujocos[mjNGEOMTYPES]{};  // functions that ours replace, by the other shape's type

/// The ground's surface, in the frame of its geom, which is turned by nothing.
class Surface {
 public:
  Surface(const mjModel* m, const mjData* d, int geom)
      : Surface(m, m->geom_dataid[geom],
                Vec3{d->geom_xpos[3 * geom], d->geom_xpos[3 * geom + 1], d->geom_xpos[3 * geom + 2]}) {}

  double top_m() const { return origin_.z + top_; }
  /// Height and normal at a place; false: the ground ends before it.
  bool at(double x, double y, double& height, Vec3& normal) const {
    const double u = (x - origin_.x + half_x_) / step_x_, v = (y - origin_.y + half_y_) / step_y_;
    if (!(u >= 0 && v >= 0 && u < columns_ - 1 && v < rows_ - 1)) return false;
    const int c = static_cast<int>(u), r = static_cast<int>(v);
    const double fu = u - c, fv = v - r;
    const double h00 = point(r, c), h01 = point(r, c + 1), h10 = point(r + 1, c), h11 = point(r + 1, c + 1);
    const double low = h00 + (h01 - h00) * fu, high = h10 + (h11 - h10) * fu;
    height = origin_.z + low + (high - low) * fv;
    const double slope_x = ((h01 - h00) * (1 - fv) + (h11 - h10) * fv) / step_x_, slope_y = (high - low) / step_y_;
    normal = math::normalized(Vec3{-slope_x, -slope_y, 1});
    return true;
  }
  /// Calls take(Vec3) for each of its points in a rectangle.
  template <class Take>
  void points_in(double x0, double x1, double y0, double y1, Take take) const {
    const auto from = [](double at, double half, double step) {
      return at + half > 0 ? static_cast<int>(math::ceil((at + half) / step)) : 0;
    };
    for (int r = from(y0 - origin_.y, half_y_, step_y_); r < rows_ && row_y(r) <= y1; ++r)
      for (int c = from(x0 - origin_.x, half_x_, step_x_); c < columns_ && column_x(c) <= x1; ++c)
        take(Vec3{column_x(c), row_y(r), origin_.z + point(r, c)});
  }

 private:
  Surface(const mjModel* m, int field, const Vec3& origin)
      : origin_(origin),
        heights_(m->hfield_data + m->hfield_adr[field]),
        rows_(m->hfield_nrow[field]),
        columns_(m->hfield_ncol[field]),
        half_x_(m->hfield_size[4 * field]),
        half_y_(m->hfield_size[4 * field + 1]),
        top_(m->hfield_size[4 * field + 2]),
        step_x_(2 * half_x_ / (columns_ - 1)),
        step_y_(2 * half_y_ / (rows_ - 1)) {}
  double point(int row, int column) const { return top_ * static_cast<double>(heights_[row * columns_ + column]); }
  double row_y(int row) const { return origin_.y - half_y_ + step_y_ * row; }
  double column_x(int column) const { return origin_.x - half_x_ + step_x_ * column; }

  Vec3 origin_;
  const float* heights_;
  int rows_, columns_;
  double half_x_, half_y_, top_, step_x_, step_y_;
};

/// A shape in the world.
struct Placed {
  Vec3 middle, size;
  std::array<Vec3, 3> axis;

  Placed(const mjModel* m, const mjData* d, int geom) {
    const mjtNum *p = d->geom_xpos + 3 * geom, *turn = d->geom_xmat + 9 * geom, *s = m->geom_size + 3 * geom;
    middle = {p[0], p[1], p[2]}, size = {s[0], s[1], s[2]};
    for (std::size_t i = 0; i < 3; ++i) axis[i] = {turn[i], turn[3 + i], turn[6 + i]};
  }
};

/// The deepest contacts of a pair.
class Deepest {
 public:
  Deepest(mjContact* out, double margin) : out_(out), margin_(margin) {}
  void add(const Vec3& at, const Vec3& normal, double dist) {
    if (!(dist < margin_)) return;
    int slot = count_;
    if (count_ < kMostContacts) {
      ++count_;
    } else {  // the least deep one goes
      slot = 0;
      for (int i = 1; i < kMostContacts; ++i)
        if (out_[i].dist > out_[slot].dist) slot = i;
      if (out_[slot].dist <= dist) return;
    }
    mjContact& c = out_[slot];
    c.dist = dist;
    for (int i = 0; i < 3; ++i) c.pos[i] = at[i], c.frame[i] = normal[i], c.frame[3 + i] = 0;
  }
  int count() const { return count_; }

 private:
  mjContact* out_;
  double margin_;
  int count_ = 0;
};

/// A point of a shape against the surface.
void add_point(const Surface& ground, const Vec3& p, Deepest& out) {
  double height = 0;
  Vec3 normal;
  if (!ground.at(p.x, p.y, height, normal)) return;
  const double dist = (p.z - height) * normal.z;
  out.add(p - normal * (dist / 2), normal, dist);
}

/// A ball around a point.
void add_ball(const Surface& ground, const Vec3& p, double radius_m, Deepest& out) {
  double height = 0;
  Vec3 normal;
  if (!ground.at(p.x, p.y, height, normal)) return;
  const double dist = (p.z - height) * normal.z - radius_m;
  out.add(p - normal * (radius_m + dist / 2), normal, dist);
}

void add_box(const Surface& ground, const Placed& box, Deepest& out) {
  const Vec3 x = box.axis[0] * box.size.x, y = box.axis[1] * box.size.y, z = box.axis[2] * box.size.z;
  for (int i = 0; i < 8; ++i)
    add_point(ground, box.middle + x * (i & 1 ? 1 : -1) + y * (i & 2 ? 1 : -1) + z * (i & 4 ? 1 : -1), out);
  const double reach_x = math::fabs(x.x) + math::fabs(y.x) + math::fabs(z.x);
  const double reach_y = math::fabs(x.y) + math::fabs(y.y) + math::fabs(z.y);
  ground.points_in(box.middle.x - reach_x, box.middle.x + reach_x, box.middle.y - reach_y, box.middle.y + reach_y,
                   [&](const Vec3& p) {
                     double deep = math::kInf;
                     Vec3 normal;
                     for (std::size_t k = 0; k < 3; ++k) {
                       const double along = dot(p - box.middle, box.axis[k]), half = box.size[static_cast<int>(k)];
                       if (math::fabs(along) >= half) return;
                       const double up = box.axis[k].z;
                       if (math::fabs(up) < kFaceLooksDown) continue;
                       const double from_face = up > 0 ? along + half : half - along;
                       if (from_face >= deep) continue;
                       deep = from_face;
                       normal = up > 0 ? box.axis[k] : -box.axis[k];
                     }
                     if (deep < math::kInf) out.add(p - normal * (deep / 2), normal, -deep);
                   });
}

void add_cylinder(const Surface& ground, const Placed& c, Deepest& out) {
  // The rim's lowest and highest points, and those between.
  const Vec3 along = c.axis[2];
  Vec3 down = math::normalized(along * along.z - Vec3{0, 0, 1});
  if (norm(down) < 0.5) down = c.axis[0];
  const Vec3 aside = cross(along, down);
  for (const double face : {-c.size.y, c.size.y})
    for (const Vec3& way : {down, -down, aside, -aside})
      add_point(ground, c.middle + along * face + way * c.size.x, out);
}

int own_contacts(const mjModel* m, const mjData* d, mjContact* con, int field, int other, mjtNum margin) {
  const int type = m->geom_type[other];
  if (m->geom_contype[field] != kUneven) return mujocos[type](m, d, con, field, other, margin);
  const Surface ground(m, d, field);
  if (d->geom_xpos[3 * other + 2] - m->geom_rbound[other] > ground.top_m() + margin) return 0;
  const Placed shape(m, d, other);
  Deepest out(con, margin);
  if (type == mjGEOM_BOX) {
    add_box(ground, shape, out);
  } else if (type == mjGEOM_SPHERE) {
    add_ball(ground, shape.middle, shape.size.x, out);
  } else if (type == mjGEOM_CYLINDER) {
    add_cylinder(ground, shape, out);
  } else {
    const int parts = static_cast<int>(math::ceil(2 * shape.size.y / kAlongCapsule_m));
    for (int i = 0; i <= parts; ++i)
      add_ball(ground, shape.middle + shape.axis[2] * (shape.size.y * (2.0 * i / std::max(1, parts) - 1)), shape.size.x,
               out);
  }
  return out.count();
}

}  // namespace

void use_own_ground_contacts() {
  for (const int type : {mjGEOM_SPHERE, mjGEOM_CAPSULE, mjGEOM_CYLINDER, mjGEOM_BOX}) {
    mjfCollision& entry = mjCOLLISIONFUNC[mjGEOM_HFIELD][type];
    if (entry == own_contacts) continue;
    mujocos[type] = entry;
    entry = own_contacts;
  }
}

}  // namespace sinew::plant
