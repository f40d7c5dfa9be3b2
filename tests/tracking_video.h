#ifndef TOPOTAG_TESTS_TRACKING_VIDEO_H_
#define TOPOTAG_TESTS_TRACKING_VIDEO_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/scene_util.h"
#include "topotag/renderer.h"

namespace topotag::test {

/// A video of markers that fly about in front of a camera.
struct VideoSettings {
  int width = 1280;
  int height = 960;
  int frames = 1000;
  int markers = 1;
  double max_step = 0.6;     ///< of a marker, its own sides a frame
  double spin = 0.08;        ///< about its normal, at most so many radians a frame
  double max_tilt = 50;      ///< degrees
  double exposure = 0.0005;  ///< seconds
  double frame_time = 1.0 / 30;
  int card_steps = 12;     ///< frames in which a card slides over a marker, or from it
  int card_stays = 20;     ///< frames in which it stays
  ImageView background{};  ///< its data may be null
  uint64_t seed = 1;
};

/// Each marker goes from one random place in the picture to the next, sharp turns at each of them
/// and a new speed after it, while it turns in its plane, tilts and comes and goes. Twice, a card
/// that is larger than a marker slides over each, stays, and slides on.
class TrackingVideo {
 public:
  explicit TrackingVideo(const VideoSettings& settings) : settings_(settings) {
    Random random(settings.seed);
    for (int i = 0; i < settings.markers; ++i) flights_.push_back(MakeFlight(&random));
  }

  int frames() const { return settings_.frames; }

  Scene At(int frame) const {
    Scene scene;
    scene.camera = PinholeCamera(settings_.width, settings_.height, Focal());
    scene.background_image = settings_.background;
    scene.exposure = settings_.exposure;
    scene.seed = settings_.seed + static_cast<uint64_t>(frame);
    for (size_t i = 0; i < flights_.size(); ++i) {
      scene.markers.push_back(MarkerAt(i, frame));
      AddCard(frame, static_cast<int>(i), &scene);
    }
    return scene;
  }

 private:
  static constexpr double kCardHalf = 14;  // units, and the marker with its frame has 9.5
  static constexpr double kAway = 26;      // of its centre, where it does not touch the marker

  struct State {
    Point2 place;  // pixels
    double depth;
    double roll;
  };
  struct Flight {
    MarkerDesign design;
    std::vector<State> states;  // of each frame, one before and one behind
    double tilt_phase;
  };

  double Focal() const { return 695.0 / 1280 * settings_.width; }
  double Side(double depth) const { return Focal() * SceneMarker().tag_size / depth; }

  Flight MakeFlight(Random* random) const {
    Flight flight;
    flight.design.id = random->Below(flight.design.family.size());
    flight.tilt_phase = random->Uniform(0, 6);
    const double nearest = 0.35, farthest = 0.6, border = 0.8 * Side(nearest);
    const auto waypoint = [&] {
      return State{{random->Uniform(border, settings_.width - border),
                    random->Uniform(border, settings_.height - border)},
                   random->Uniform(nearest, farthest),
                   0};
    };
    State now = waypoint(), goal = waypoint();
    double step = settings_.max_step, spin = settings_.spin;
    for (int frame = -1; frame <= settings_.frames; ++frame) {
      flight.states.push_back(now);
      double left = Distance(now.place, goal.place);
      const double length = step * Side(now.depth);
      if (left <= length) {
        goal = waypoint();
        left = Distance(now.place, goal.place);
        step = settings_.max_step * random->Uniform(0.1, 1);
        spin = settings_.spin * random->Uniform(-1, 1);
      }
      const double share = std::min(step * Side(now.depth) / left, 1.0);
      now.place.x += share * (goal.place.x - now.place.x);
      now.place.y += share * (goal.place.y - now.place.y);
      now.depth += share * (goal.depth - now.depth);
      now.roll += spin;
    }
    return flight;
  }

  Vector3 Position(const State& state) const {
    return {(state.place.x - (settings_.width - 1) / 2.0) / Focal() * state.depth,
            (state.place.y - (settings_.height - 1) / 2.0) / Focal() * state.depth, state.depth};
  }

  SceneMarker MarkerAt(size_t i, int frame) const {
    const Flight& flight = flights_[i];
    const auto index = static_cast<size_t>(frame + 1);
    const State& now = flight.states[index];
    SceneMarker marker;
    marker.design = flight.design;
    const double tilt =
        settings_.max_tilt * kDegree * (0.5 + 0.5 * std::sin(flight.tilt_phase + 0.05 * frame));
    const double axis = flight.tilt_phase + 0.03 * frame;
    marker.R = RotationZ(axis) * (RotationX(tilt) * RotationZ(now.roll - axis));
    marker.t = Position(now);
    const Vector3 before = Position(flight.states[index - 1]);
    const Vector3 after = Position(flight.states[index + 1]);
    for (size_t k = 0; k < 3; ++k) {
      marker.velocity[k] = (after[k] - before[k]) / (2 * settings_.frame_time);
    }
    return marker;
  }

  // Two times of the video, a few frames apart for each marker.
  void AddCard(int frame, int marker, Scene* scene) const {
    for (const double part : {0.3, 0.7}) {
      const int since = frame - static_cast<int>(part * settings_.frames) - 7 * marker;
      if (since < 0 || since > 2 * settings_.card_steps + settings_.card_stays) continue;
      const double step = kAway / settings_.card_steps;
      const double x = since < settings_.card_steps ? step * since - kAway
                       : since < settings_.card_steps + settings_.card_stays
                           ? 0
                           : step * (since - settings_.card_steps - settings_.card_stays);
      Occluder card;
      card.outline = {{x - kCardHalf, -kCardHalf},
                      {x + kCardHalf, -kCardHalf},
                      {x + kCardHalf, kCardHalf},
                      {x - kCardHalf, kCardHalf}};
      card.level = 70;
      card.marker = marker;
      scene->occluders.push_back(card);
    }
  }

  VideoSettings settings_;
  std::vector<Flight> flights_;
};

}  // namespace topotag::test

#endif  // TOPOTAG_TESTS_TRACKING_VIDEO_H_
