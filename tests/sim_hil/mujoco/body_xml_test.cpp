// Bodies in MuJoCo beside our own kinematics of them.
#include "sim_hil/mujoco/body_xml.hpp"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "apps/toml/body_reader.hpp"
#include "math/hash.hpp"
#include "math/random.hpp"
#include "sim_hil/mujoco/room.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::plant {
namespace {

using kinematics::Body;
using kinematics::BodyPose;
using math::Vec3;

Body body_of(const char* name) {
  app::LoadedBody loaded = app::load_body(test::source_dir() + "/robots/kid/" + name + ".toml");
  for (const auto& p : loaded.problems) ADD_FAILURE() << rt::to_string(p, name);
  return loaded.body;
}

ModelPtr model_of(const std::string& bodies) {
  auto model = load_room(
      "<mujoco><compiler angle=\"radian\" discardvisual=\"false\"/>"
      "<option timestep=\"0.002\" solver=\"Newton\" jacobian=\"sparse\"/>"
      "<size njmax=\"2000\" nconmax=\"500\" nstack=\"4000000\"/><worldbody>"
      "<geom type=\"plane\" size=\"5 5 1\"/>" +
          bodies + "</worldbody></mujoco>",
      RoomUse::physics);
  EXPECT_TRUE(model);
  return model ? std::move(*model) : nullptr;
}

Vec3 vec(const mjtNum* v) { return {v[0], v[1], v[2]}; }

class BodyInMujoco : public ::testing::TestWithParam<const char*> {};

TEST_P(BodyInMujoco, HasItsLinksItsCentreOfMassAndItsJacobiansWhereOurKinematicsHaveThem) {
  const Body body = body_of(GetParam());
  ASSERT_GE(body.joints(), 20u);
  const ModelPtr model = model_of(body_xml(body, {.name_end = "", .at_m = {}}));
  ASSERT_TRUE(model);
  const DataPtr data(mj_makeData(model.get()));
  math::Random random(1);
  BodyPose pose(body);
  for (int trial = 0; trial < 50; ++trial) {
    const kinematics::Pose base{Vec3{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)},
                                math::Quat::exp({random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)})};
    std::vector<double> rad(body.joints());
    for (std::size_t j = 0; j < rad.size(); ++j) {
      rad[j] = random.uniform(body.links[j + 1].least_rad, body.links[j + 1].most_rad);
      const int joint = mj_name2id(model.get(), mjOBJ_JOINT, body.links[j + 1].name.c_str());
      ASSERT_GE(joint, 0);
      data->qpos[model->jnt_qposadr[joint]] = rad[j];
    }
    const double start[7] = {base.p_m.x, base.p_m.y, base.p_m.z, base.q.w, base.q.x, base.q.y, base.q.z};
    std::copy_n(start, 7, data->qpos);
    mj_kinematics(model.get(), data.get());
    mj_comPos(model.get(), data.get());
    pose.set(rad, base);
    const int torso = mj_name2id(model.get(), mjOBJ_BODY, "torso");
    EXPECT_LT(norm(vec(data->subtree_com + 3 * torso) - pose.centre_of_mass()), 1e-12);
    EXPECT_NEAR(mj_getTotalmass(model.get()), body.mass_kg(), 1e-9);
    std::vector<Vec3> linear(body.joints()), angular(body.joints());
    std::vector<mjtNum> jacp(3 * static_cast<std::size_t>(model->nv)), jacr(jacp.size());
    for (std::size_t i = 0; i < body.links.size(); ++i) {
      const int id = mj_name2id(model.get(), mjOBJ_BODY, body.links[i].name.c_str());
      ASSERT_GE(id, 0);
      EXPECT_LT(norm(vec(data->xpos + 3 * id) - pose.link(i).p_m), 1e-12) << body.links[i].name;
      const mjtNum* q = data->xquat + 4 * id;
      EXPECT_LT(angle_between({q[0], q[1], q[2], q[3]}, pose.link(i).q), 1e-7) << body.links[i].name;
      const Vec3 point{0.01, -0.02, 0.03}, there = pose.link(i).of(point);
      const mjtNum at[3] = {there.x, there.y, there.z};
      mj_jac(model.get(), data.get(), jacp.data(), jacr.data(), at, id);
      pose.jacobian(i, point, linear, angular);
      for (std::size_t j = 0; j < body.joints(); ++j) {
        const int dof = model->jnt_dofadr[mj_name2id(model.get(), mjOBJ_JOINT, body.links[j + 1].name.c_str())];
        const auto column = [&](const std::vector<mjtNum>& jac) {
          const auto nv = static_cast<std::size_t>(model->nv), d = static_cast<std::size_t>(dof);
          return Vec3{jac[d], jac[nv + d], jac[2 * nv + d]};
        };
        EXPECT_LT(norm(column(jacp) - linear[j]), 1e-12);
        EXPECT_LT(norm(column(jacr) - angular[j]), 1e-12);
      }
    }
    for (const auto& place : body.places) {
      const int site = mj_name2id(model.get(), mjOBJ_SITE, place.name.c_str());
      ASSERT_GE(site, 0);
      EXPECT_LT(norm(vec(data->site_xpos + 3 * site) - pose.place(place).p_m), 1e-12) << place.name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, BodyInMujoco, ::testing::Values("op3", "nao"));

/// Two bodies fall limp onto the floor and onto each other; a hash of where everything is after each step.
std::uint64_t hash_of_a_fall() {
  const Body op3 = body_of("op3"), nao = body_of("nao");
  const ModelPtr model = model_of(body_xml(op3, {.name_end = "1", .at_m = {0, 0, 0.32}}) +
                                  body_xml(nao, {.name_end = "2", .at_m = {0.05, 0.02, 0.9}}));
  const DataPtr data(mj_makeData(model.get()));
  std::uint64_t hash = math::fnv1a64("");
  int contacts = 0;
  for (int step = 0; step < 2000; ++step) {
    mj_step(model.get(), data.get());
    contacts = std::max(contacts, data->ncon);
    hash = math::fnv1a64(
        {reinterpret_cast<const char*>(data->qpos), sizeof(mjtNum) * static_cast<std::size_t>(model->nq)}, hash);
  }
  EXPECT_GT(contacts, 8);
  return hash;
}

TEST(MujocoSteps, HaveTheSameBytesWhereTheCLibraryUsesNoFma) {
  const std::uint64_t here = hash_of_a_fall();
  if (std::getenv("SINEW_HASH_OF_A_FALL")) {
    std::printf("hash %016llx\n", static_cast<unsigned long long>(here));
    return;
  }
  char self[4096] = "";
  ASSERT_GT(readlink("/proc/self/exe", self, sizeof self - 1), 0);
  const std::string command =
      "SINEW_HASH_OF_A_FALL=1 GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512DQ,-AVX512BW,-AVX512CD,-AVX2,"
      "-AVX,-FMA,-FMA4 '" +
      std::string(self) + "' --gtest_filter=MujocoSteps.*";
  FILE* const other = popen(command.c_str(), "r");
  ASSERT_TRUE(other);
  char line[256];
  unsigned long long there = 0;
  bool told = false;
  while (std::fgets(line, sizeof line, other)) told = told || std::sscanf(line, "hash %llx", &there) == 1;
  EXPECT_EQ(pclose(other), 0);
  ASSERT_TRUE(told);
  EXPECT_EQ(here, there);
}

}  // namespace
}  // namespace sinew::plant
