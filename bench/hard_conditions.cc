#include "bench/hard_conditions.h"

#include <cmath>

namespace topotag::bench {
namespace {

using test::Random;

/// A gain of 0.7 at the marker's centre, changing by 0.5 % of it a pixel, in any direction.
void AddGradient(Scene* scene, Random* random) {
  const double angle = random->Uniform(0, 2 * M_PI);
  const Point2 center = GroundTruth(*scene, 0).center;
  const double dx = center.x - (scene->camera.width - 1) / 2.0;
  const double dy = center.y - (scene->camera.height - 1) / 2.0;
  Point2 slope{0.005 * std::cos(angle), 0.005 * std::sin(angle)};
  // Darker towards the middle of the frame there would be no light left in it.
  if (slope.x * dx + slope.y * dy > 0) slope = {-slope.x, -slope.y};
  const double middle = 1 - slope.x * dx - slope.y * dy;
  scene->lighting.gain = 0.7 * middle;
  scene->lighting.gradient = {slope.x / middle, slope.y / middle};
}

HardCondition Gain(const std::string& name, double gain) {
  return {name, [gain](Scene* scene, Random*) { scene->lighting.gain = gain; }};
}

HardCondition Shaded(const std::string& name, double factor, double penumbra) {
  return {name, [factor, penumbra](Scene* scene, Random* random) {
            AddShadow(factor, penumbra, scene, random);
          }};
}

HardCondition MotionBlur(const std::string& name, double pixels) {
  return {name, [pixels](Scene* scene, Random* random) {
            scene->exposure = 0.01;
            Move(pixels, scene->exposure, scene, random);
          }};
}

/// Skewed by so many pixels over 100 rows.
HardCondition RollingShutter(const std::string& name, double pixels) {
  return {name, [pixels](Scene* scene, Random* random) {
            scene->row_time = 1e-5;
            Move(pixels, 100 * scene->row_time, scene, random);
          }};
}

HardCondition Blurred(const std::string& name, double sigma) {
  return {name, [sigma](Scene* scene, Random*) { scene->blur = sigma; }};
}

HardCondition Noisy(const std::string& name, double sigma) {
  return {name, [sigma](Scene* scene, Random*) { scene->noise = sigma; }};
}

HardCondition Grown(const std::string& name, double units) {
  return {name, [units](Scene* scene, Random*) { scene->markers[0].growth = units; }};
}

/// A strip along one side of the white area hides this share of it.
HardCondition Hidden(const std::string& name, double share) {
  return {name, [share](Scene* scene, Random* random) {
            const double side = scene->markers[0].design.family.white_side(), half = side / 2;
            const double in = share * side - half, out = half + 1.5;
            const std::vector<Point2> strips[] = {
                {{-out, -out}, {out, -out}, {out, in}, {-out, in}},
                {{-out, -in}, {out, -in}, {out, out}, {-out, out}},
                {{-out, -out}, {in, -out}, {in, out}, {-out, out}},
                {{-in, -out}, {out, -out}, {out, out}, {-in, out}}};
            scene->occluders = {{strips[random->Below(4)], 120, 0}};
          }};
}

}  // namespace

void AddShadow(double factor, double penumbra, Scene* scene, Random* random) {
  const Detection truth = GroundTruth(*scene, 0);
  const double third = test::Distance(truth.corners[0], truth.corners[1]) / 3;
  Shadow shadow;
  shadow.angle = random->Uniform(0, 2 * M_PI);
  const double offset = random->Uniform(-third, third);
  shadow.point = {truth.center.x + offset * std::cos(shadow.angle),
                  truth.center.y + offset * std::sin(shadow.angle)};
  shadow.factor = factor;
  shadow.penumbra = penumbra;
  scene->lighting.shadow = shadow;
}

void Move(double pixels, double seconds, Scene* scene, Random* random) {
  SceneMarker& marker = scene->markers[0];
  const double angle = random->Uniform(0, 2 * M_PI);
  const double speed = pixels / seconds * marker.t[2] / scene->camera.fx;
  marker.velocity = {speed * std::cos(angle), speed * std::sin(angle), 0};
}

void AddHighlight(double level, Scene* scene, Random* random) {
  Point2 center = GroundTruth(*scene, 0).center;
  center.x += random->Uniform(-30, 30);
  center.y += random->Uniform(-30, 30);
  scene->lighting.highlights = {{center, 12, level}};
}

std::vector<HardCondition> HardConditions() {
  return {
      {"plain", [](Scene*, Random*) {}},
      Gain("dark (white 43)", 0.2),
      Gain("overexposed (white 290)", 1.35),
      {"ink of 40 % of white",
       [](Scene* scene, Random*) { scene->markers[0].black = 0.4 * scene->markers[0].white; }},
      Shaded("hard shadow edge to 50 %", 0.5, 0),
      Shaded("hard shadow edge to 25 %", 0.25, 0),
      Shaded("shadow to 25 %, penumbra 10 px", 0.25, 10),
      {"gain gradient 0.5 % a pixel", AddGradient},
      {"highlight +150, sigma 12 px",
       [](Scene* scene, Random* random) { AddHighlight(150, scene, random); }},
      MotionBlur("motion blur 3 px", 3),
      MotionBlur("motion blur 6 px", 6),
      RollingShutter("rolling shutter 5 px in 100 rows", 5),
      RollingShutter("rolling shutter 20 px in 100 rows", 20),
      Blurred("defocus, sigma 1.5 px", 1.5),
      Blurred("defocus, sigma 2.5 px", 2.5),
      Noisy("noise sigma 10", 10),
      Noisy("noise sigma 30", 30),
      Noisy("noise sigma 115", 115),
      Grown("ink growth 0.15 units (ours)", 0.15),
      Grown("ink growth -0.15 units (ours)", -0.15),
      Hidden("10 % hidden", 0.1),
      Hidden("25 % hidden", 0.25),
      Hidden("40 % hidden", 0.4),
  };
}

}  // namespace topotag::bench
