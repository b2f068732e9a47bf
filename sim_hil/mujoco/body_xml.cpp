#include "sim_hil/mujoco/body_xml.hpp"

#include <charconv>

namespace sinew::plant {
namespace {

using kinematics::Body;
using kinematics::Link;
using kinematics::Shape;

std::string number(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}
std::string numbers(const math::Vec3& v) { return number(v.x) + ' ' + number(v.y) + ' ' + number(v.z); }
std::string numbers(const math::Quat& q) {
  return number(q.w) + ' ' + number(q.x) + ' ' + number(q.y) + ' ' + number(q.z);
}

class Writer {
 public:
  Writer(const Body& body, const BodyXml& options) : body_(body), o_(options) {}

  std::string link(std::size_t i) {
    const Link& l = body_.links[i];
    std::string out =
        "<body name=\"" + l.name + o_.name_end + "\" pos=\"" + numbers(i == 0 ? o_.at_m : l.at_m) + "\">\n";
    if (i > 0) {
      const double armature = l.servo < body_.servos.size() ? body_.servos[l.servo].armature_kgm2 : 0;
      out += "<joint name=\"" + l.name + o_.name_end + "\" type=\"hinge\" axis=\"" + numbers(l.axis) +
             "\" limited=\"true\" range=\"" + number(l.least_rad) + ' ' + number(l.most_rad) + "\" armature=\"" +
             number(armature) + "\"/>\n";
    } else if (o_.free) {
      out += "<freejoint name=\"" + l.name + o_.name_end + "\"/>\n";
    }
    if (l.mass_kg > 0) {
      out += "<inertial pos=\"" + numbers(l.com_m) + "\" mass=\"" + number(l.mass_kg) + "\" fullinertia=\"";
      for (const double value : l.inertia_kgm2) out += number(value) + ' ';
      out.back() = '"';
      out += "/>\n";
    }
    for (const Shape& s : l.shapes) out += shape(s);
    for (const kinematics::Place& p : body_.places)
      if (p.link == i)
        out += "<site name=\"" + p.name + o_.name_end + "\" pos=\"" + numbers(p.pose.p_m) + "\" quat=\"" +
               numbers(p.pose.q) + "\"/>\n";
    for (std::size_t child = i + 1; child < body_.links.size(); ++child)
      if (body_.links[child].parent == i) out += link(child);
    return out + "</body>\n";
  }

 private:
  std::string shape(const Shape& s) const {
    std::string out = "<geom type=\"";
    if (s.kind == Shape::Kind::box)
      out += "box\" size=\"" + numbers(s.size_m * 0.5);
    else if (s.kind == Shape::Kind::capsule)
      out += "capsule\" size=\"" + number(s.size_m.x) + ' ' + number(s.size_m.z / 2);
    else
      out += "sphere\" size=\"" + number(s.size_m.x);
    out += "\" pos=\"" + numbers(s.at_m) + "\" quat=\"" + numbers(s.q) + "\" friction=\"" + number(o_.friction) + '"';
    if (!o_.material.empty()) out += " material=\"" + o_.material + '"';
    if (!s.contact) out += " contype=\"0\" conaffinity=\"0\"";
    return out + "/>\n";
  }

  const Body& body_;
  const BodyXml& o_;
};

}  // namespace

std::string body_xml(const Body& body, const BodyXml& options) { return Writer(body, options).link(0); }

}  // namespace sinew::plant
