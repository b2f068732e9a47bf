#include "sim_hil/mujoco/room.hpp"

#include <mujoco/mujoco.h>

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

}  // namespace

void MujocoDelete::operator()(mjModel_* m) const { mj_deleteModel(m); }
void MujocoDelete::operator()(mjData_* d) const { mj_deleteData(d); }

hal::Result<ModelPtr> load_room(std::string_view text, RoomUse use) {
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
  return model;
}

}  // namespace sinew::plant
