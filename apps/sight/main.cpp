// sinew-sight: what robots see of a game, judged against the truth; and the ball classifier trained.
// docs/soccer-vision.md.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "apps/sight/carpets.hpp"
#include "apps/sight/draw.hpp"
#include "apps/sight/judge.hpp"
#include "apps/sight/photos.hpp"
#include "apps/sight/train.hpp"
#include "apps/toml/body_reader.hpp"

namespace {

using namespace sinew;
using namespace sinew::sight;

constexpr int kOk = 0, kNotBegun = 2;
constexpr std::uint64_t kOddsSeed = 1000;  // on top of the seed, of the scenes that confidences are made from
constexpr int kPhotoWeight = 5;            // times that each patch of a photo is among the examples

struct Options {
  std::string body = "robots/kid/op3.toml", out, photos, cache;
  SceneOptions scene;
  std::string light = "unseen";
  std::uint64_t count = 1000, first = 0;
  bool missed = false, wrong = false, losses = false;
  Training training;
};

int fail(const std::string& what) {
  std::fprintf(stderr, "sinew-sight: %s\n", what.c_str());
  return kNotBegun;
}

bool set_light(Options& o) {
  o.scene.lighting = o.light == "clean" ? Lighting::clean : o.light == "tuning" ? Lighting::tuning : Lighting::unseen;
  return true;
}

int run_judge(const Options& o, const kinematics::Body& body) {
  SceneMaker maker(body, o.scene);
  Judgement j;
  judge(maker, o.first, o.count, {}, j);
  std::printf("%u x %u, light: %s, seed %llu\n%s", o.scene.width, o.scene.height, o.light.c_str(),
              static_cast<unsigned long long>(o.scene.seed), report(j).c_str());
  if (o.losses) std::printf("\n%s", losses(j).c_str());
  return kOk;
}

/// Of both sizes of picture; from `cache` if that file is there, else kept in it.
bool patches(const Options& o, const kinematics::Body& body, bool as_they_come, std::vector<Example>& out,
             std::string& why) {
  const std::string cache = o.cache.empty() ? "" : o.cache + (as_they_come ? ".odds" : ".patches");
  if (!cache.empty() && std::filesystem::exists(cache)) return load(cache, out, why);
  for (const std::uint32_t width : {320U, 640U}) {
    SceneOptions s = o.scene;
    s.width = width, s.height = width * 3 / 4;
    s.lighting = Lighting::tuning, s.seek_ball = !as_they_come;
    if (as_they_come) s.seed += kOddsSeed;
    SceneMaker maker(body, s);
    collect(maker, 0, (as_they_come ? o.count / 4 : o.count) / (width == 320 ? 1 : 3), as_they_come, out);
  }
  return cache.empty() || save(cache, out, why);
}

int run_train(const Options& o, const kinematics::Body& body) {
  std::vector<Example> examples, odds;
  std::string why;
  if (!patches(o, body, false, examples, why) || !patches(o, body, true, odds, why)) return fail(why);
  if (!o.photos.empty()) {
    const std::vector<Photo> photos = load_photos(o.photos, why);
    if (photos.empty()) return fail(why);
    const auto half = std::span<const Photo>(photos).first(photos.size() / 2);
    std::vector<Example> real;
    collect(half, fit_camera(half, kMslBallRadius_m), real);
    std::fprintf(stderr, "%zu patches of photos\n", real.size());
    for (int k = 0; k < kPhotoWeight; ++k) examples.insert(examples.end(), real.begin(), real.end());
  }
  std::size_t balls = 0;
  for (const Example& e : examples) balls += e.is_ball;
  std::fprintf(stderr, "%zu patches, %zu of balls\n", examples.size(), balls);
  if (examples.size() < 1000 || odds.size() < 1000) return fail("too few patches");
  std::vector<float> weights = train(examples, o.training);
  calibrate(weights, odds);
  std::ofstream file(o.out);
  file << weights_source(weights, "sinew-sight train --count " + std::to_string(o.count) + " --epochs " +
                                      std::to_string(o.training.epochs) +
                                      (o.photos.empty() ? "" : " --photos ../shared/data/robocup_msl") +
                                      " --out soccer/sight/ball_weights.cpp");
  return file.flush() ? kOk : fail(o.out + " cannot be written");
}

/// The first half by time is for training, the second is kept back.
int run_photos(const Options& o) {
  std::string why;
  const std::vector<Photo> photos = load_photos(o.photos, why);
  if (photos.empty()) return fail(why);
  const std::size_t half = photos.size() / 2;
  const std::span<const Photo> all(photos);
  const PhotoCamera camera = fit_camera(all.first(half), kMslBallRadius_m);
  std::printf("camera: horizon at row %.1f, %.2f m high (by the labels of the first half)\n", camera.horizon_px,
              camera.height_m);
  for (const bool kept : {false, true}) {
    const auto part = kept ? all.subspan(half) : all.first(half);
    std::string lines;
    const Judgement j = judge(part, camera, lines);
    const auto fixed = j.at_confidence(0.5), sure = j.at_precision(0.99);
    std::printf(
        "%s half, %zu photos\n%sballs among the candidates: %s\nfound, confidence 0.5: %s, right: %s\n"
        "found at 99 %% precision: %s\n",
        kept ? "kept back: second" : "first", part.size(), lines.c_str(), text({j.balls_candidates, j.balls}).c_str(),
        text(fixed.recall).c_str(), text(fixed.precision).c_str(), text(sure.recall).c_str());
  }
  if (o.out.empty()) return kOk;
  soccer::SightOptions so;
  so.ball_radius_m = kMslBallRadius_m, so.ball_farthest_m = 13;
  so.most_width = msg::kMaxImageWidth, so.most_height = msg::kMaxImageHeight;
  soccer::FieldSight sight(so);
  const soccer::GroundView view(camera.camera, camera.pose(), {}, {});
  std::vector<Drawing> drawings;
  msg::SoccerSight seen;
  for (const Photo& p : all.subspan(o.first, std::min<std::size_t>(o.count, photos.size() - o.first)))
    if (sight.look(p.view(), view, seen)) drawings.push_back(draw(p.view(), view, sight, seen));
  return write_png(o.out, side_by_side(drawings, 2)) ? kOk : fail(o.out + " cannot be written");
}

int run_colours(const std::string& source, const RecordTopics& topics, double height_m) {
  Carpets carpets;
  std::string why;
  if (std::filesystem::is_directory(source)) {
    const std::vector<Photo> photos = load_photos(source, why);
    if (photos.empty()) return fail(why);
    measure_photos(photos, height_m, carpets);
  } else if (!measure_record(source, topics, carpets, why)) {
    return fail(why);
  }
  if (carpets.looks.empty()) return fail(source + ": no picture shows enough of a green carpet");
  std::printf("%s", report(carpets).c_str());
  return kOk;
}

int run_pictures(const Options& o, const kinematics::Body& body) {
  SceneMaker maker(body, o.scene);
  soccer::FieldSight sight;
  msg::SoccerSight seen;
  Scene scene;
  std::vector<Drawing> all;
  for (std::uint64_t n = o.first; all.size() < o.count; ++n) {
    maker.make(n, scene);
    const soccer::GroundView view = scene.ground(false);
    if (!sight.look(scene.view(), view, seen) || !sight.border().found()) continue;
    if (o.missed) {
      const auto& b = scene.ball;
      if (!b || b->visible < 0.6 || b->radius_px < 4 || !sight.picture().holds(b->u_px, b->v_px)) continue;
      bool found = false;
      for (const auto& c : sight.candidates().all()) found = found || verdict(c, b) == Verdict::ball;
      if (found) continue;
    }
    if (o.wrong) {
      bool wrong = false;
      for (std::uint32_t i = 0; i < seen.balls; ++i)
        wrong = wrong || !scene.ball || !(scene.ball->visible > 0.02) ||
                math::hypot(seen.ball[i].u_px - scene.ball->u_px, seen.ball[i].v_px - scene.ball->v_px) >
                    0.6 * scene.ball->radius_px + 1.5;
      if (!wrong) continue;
    }
    all.push_back(draw(scene.view(), view, sight, seen));
  }
  return write_png(o.out, side_by_side(all, 3)) ? kOk : fail(o.out + " cannot be written");
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App app("What robots see of a game: docs/soccer-vision.md");
  app.require_subcommand(1);
  const auto common = [&](CLI::App* sub) {
    sub->add_option("--body", o.body, "of all robots");
    sub->add_option("--seed", o.scene.seed, "of the scenes");
    sub->add_option("--count", o.count, "of scenes");
    sub->add_option("--first", o.first, "scene");
    sub->add_option("--light", o.light)->check(CLI::IsMember({"clean", "tuning", "unseen"}));
    sub->add_option("--width", o.scene.width)->check(CLI::IsMember({320, 640}));
  };
  CLI::App* const judging = app.add_subcommand("judge", "Counts what is seen against the truth, on scenes of its own");
  CLI::App* const training = app.add_subcommand("train", "Learns the ball classifier; its weights as a source file");
  CLI::App* const pictures = app.add_subcommand("pictures", "Draws what is seen over scenes, as PNG");
  for (CLI::App* sub : {judging, training, pictures}) common(sub);
  judging->add_flag("--losses", o.losses, "says at which stage balls are lost, and what is taken for balls");
  pictures->add_flag("--missed", o.missed, "only those with a ball that is not among the candidates");
  pictures->add_flag("--wrong", o.wrong, "only those with a sighting of a ball that is none");
  training->add_option("--epochs", o.training.epochs);
  training->add_option("--cache", o.cache, "patches are kept in files of this name, and read from there the next time");
  for (CLI::App* sub : {training, pictures}) sub->add_option("--out", o.out)->required();
  CLI::App* const real =
      app.add_subcommand("photos", "Judges photos with labels: the first half by name, and the second");
  real->add_option("folder", o.photos)->required();
  real->add_option("--out", o.out, "what is seen, as PNG");
  real->add_option("--first", o.first, "photo that is drawn");
  real->add_option("--count", o.count, "of photos that are drawn");
  training->add_option("--photos", o.photos, "folder; the first half of them by name is trained with, too");
  CLI::App* const colours = app.add_subcommand(
      "colours",
      "Measures the carpet in a record or in a folder of JPEG photos; prints the look that the colour table "
      "begins with");
  std::string source;
  RecordTopics topics;
  double height_m = 0.5;
  colours->add_option("source", source, "record (MCAP), or folder")->required()->check(CLI::ExistingPath);
  colours->add_option("--image", topics.image, "topic");
  colours->add_option("--pose", topics.pose, "topic of the camera's pose");
  colours->add_option("--height", height_m, "of the level camera of photos, m")->check(CLI::Range(0.1, 5.0));
  CLI11_PARSE(app, argc, argv);
  if (colours->parsed()) return run_colours(source, topics, height_m);
  if (real->parsed()) return run_photos(o);
  o.scene.height = o.scene.width * 3 / 4;
  set_light(o);
  const app::LoadedBody loaded = app::load_body(o.body);
  for (const rt::Problem& p : loaded.problems) std::fprintf(stderr, "%s\n", rt::to_string(p, o.body).c_str());
  if (!loaded.problems.empty()) return kNotBegun;
  if (judging->parsed()) return run_judge(o, loaded.body);
  if (training->parsed()) return run_train(o, loaded.body);
  return run_pictures(o, loaded.body);
}
