#include "sim_hil/mujoco/room.hpp"

#include <mujoco/mujoco.h>

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace sinew::plant {
namespace {

[[noreturn]] void on_error(const char* text) {
  std::fprintf(stderr, "sinew-sim: MuJoCo: %s\n", text);
  std::abort();
}

void on_warning(const char* text) { std::fprintf(stderr, "sinew-sim: MuJoCo: %s\n", text); }

struct VfsDelete {
  void operator()(mjVFS* vfs) const {
    mj_deleteVFS(vfs);
    delete vfs;
  }
};

/// Copies the body with the free joint; false: there is none.
bool add_robots(std::string& xml, std::size_t robots) {
  constexpr std::string_view kBody = "<body name=", kEnd = "</body>", kName = " name=\"";
  const auto joint = xml.find("<freejoint");
  const auto begin = joint == std::string::npos ? joint : xml.rfind(kBody, joint);
  const auto end = joint == std::string::npos ? joint : xml.find(kEnd, joint);
  if (begin == std::string::npos || end == std::string::npos) return false;
  const std::string body = xml.substr(begin, end + kEnd.size() - begin);
  std::string copies;
  for (std::size_t i = 1; i < robots; ++i) {
    std::string copy = body;
    for (auto at = copy.find(kName); at != std::string::npos; at = copy.find(kName, at + 1))
      copy.insert(copy.find('"', at + kName.size()), std::to_string(i));
    copies += "\n    " + copy;
  }
  xml.insert(end + kEnd.size(), copies);
  return true;
}

/// Heights of the fields that the file only names: the text of the same name, in millimetres.
bool fill_height_fields(mjModel& model) {
  for (int i = 0; i < model.nhfield; ++i) {
    const int text = mj_name2id(&model, mjOBJ_TEXT, mj_id2name(&model, mjOBJ_HFIELD, i));
    if (text < 0) continue;
    const std::string_view words(model.text_data + model.text_adr[text]);
    const double top_mm = 1000 * model.hfield_size[4 * i + 2];
    float* out = model.hfield_data + model.hfield_adr[i];
    const char *at = words.data(), *const end = at + words.size();
    for (int k = 0; k < model.hfield_nrow[i] * model.hfield_ncol[i]; ++k) {
      while (at != end && *at == ' ') ++at;
      int height_mm = 0;
      const auto [next, error] = std::from_chars(at, end, height_mm);
      if (error != std::errc() || height_mm < 0 || height_mm > top_mm) return false;
      out[k] = static_cast<float>(height_mm / top_mm);
      at = next;
    }
  }
  return true;
}

}  // namespace

void MujocoDelete::operator()(mjModel_* m) const { mj_deleteModel(m); }
void MujocoDelete::operator()(mjData_* d) const { mj_deleteData(d); }

hal::Result<ModelPtr> load_room(std::string_view text, RoomUse use, std::size_t robots) {
  mju_user_error = on_error;  // the defaults write a log file into the working directory
  mju_user_warning = on_warning;
  std::string xml(text);
  constexpr const char* kName = "room.xml";
  constexpr std::string_view kKeep = "discardvisual=\"false\"", kDrop = "discardvisual=\"true\"";
  if (use == RoomUse::physics) {
    const auto at = xml.find(kKeep);
    if (at == std::string::npos) return hal::Error{hal::Errc::bad_data, "room: discardvisual"};
    xml.replace(at, kKeep.size(), kDrop);
  }
  const bool hang_on_joints = xml.find("<freejoint") != std::string::npos;
  if (robots > 1 && hang_on_joints && !add_robots(xml, robots))
    return hal::Error{hal::Errc::bad_data, "room: no body for more robots"};
  std::unique_ptr<mjVFS, VfsDelete> vfs(new mjVFS);
  mj_defaultVFS(vfs.get());
  if (mj_makeEmptyFileVFS(vfs.get(), kName, static_cast<int>(xml.size())) != 0)
    return hal::Error{hal::Errc::out_of_memory, "plant room"};
  std::memcpy(vfs->filedata[mj_findFileVFS(vfs.get(), kName)], xml.data(), xml.size());
  char problem[500] = "";
  ModelPtr model(mj_loadXML(kName, vfs.get(), problem, sizeof problem));
  if (!model) {
    std::fprintf(stderr, "sinew-sim: room: %s\n", problem);
    return hal::Error{hal::Errc::bad_data, "room"};
  }
  if (!fill_height_fields(*model)) {
    std::fprintf(
        stderr,
        "sinew-sim: room: a height field's text: a number of millimetres, up to its top, for each of its points\n");
    return hal::Error{hal::Errc::bad_data, "room: height field"};
  }
  // The file has room for the contacts of one robot.
  model->njmax *= static_cast<int>(robots);
  model->nconmax *= static_cast<int>(robots);
  model->nstack *= static_cast<int>(robots * robots);  // of the solver: dense matrices
  return model;
}

}  // namespace sinew::plant
