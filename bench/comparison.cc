#include "bench/comparison.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "host/stop_watch.h"

namespace topotag::bench {
namespace {

constexpr double kTurn = 20000;  // microseconds
constexpr double kLong = 50000;  // microseconds
constexpr int kMaxCounted = 10;

}  // namespace

Comparison::Comparison(const BenchScene& scene, const std::vector<Setup>& setups, int threads) {
  AddOurs(scene, setups);
  AddPeers(scene, threads);
}

void Comparison::AddOurs(const BenchScene& scene, const std::vector<Setup>& setups) {
  const auto frame = std::make_shared<const Image>(RenderTopoTags(scene));
  std::vector<int> ids;
  for (const SceneMarker& marker : scene.scene.markers) {
    ids.push_back(static_cast<int>(marker.design.id));
  }
  for (const Setup& setup : setups) {
    Options options = SceneOptions(scene);
    options.backend = setup.backend;
    options.threads = setup.threads;
    const auto detector = std::make_shared<Detector>(options);
    const auto found = std::make_shared<std::vector<Detection>>();
    Add({setup.name, Name(setup.backend), true, setup.threads, 0, 0, 0, {}}, ids,
        [frame, detector, found](std::vector<int>* out) {
          detector->detect(frame->view(), found.get());
          out->clear();
          // A marker without its pose is not found.
          for (const Detection& detection : *found) {
            if (detection.pose) out->push_back(static_cast<int>(detection.id));
          }
        });
  }
}

void Comparison::AddPeers(const BenchScene& scene, int threads) {
  std::map<std::string, std::shared_ptr<const Image>> frames;
  const Camera& camera = scene.scene.camera;
  const double frame_side = std::max(camera.width, camera.height);
  std::vector<std::unique_ptr<Peer>> peers = MakePeers({threads, scene.min_side, frame_side});
  for (std::unique_ptr<Peer>& made : peers) {
    const std::shared_ptr<Peer> peer = std::move(made);
    std::vector<int> ids;
    std::vector<BitmapMarker> markers;
    for (int id = 0; id < static_cast<int>(scene.scene.markers.size()); ++id) {
      ids.push_back(id);
      markers.push_back(peer->Marker(id));
    }
    std::shared_ptr<const Image>& frame = frames[peer->dictionary()];
    if (!frame) frame = std::make_shared<const Image>(RenderBitmaps(scene, markers));
    Add({peer->name(), peer->name(), false, threads, 0, 0, 0, {}}, ids,
        [frame, peer](std::vector<int>* out) { peer->Detect(frame->view(), out); });
  }
}

void Comparison::Add(Contestant contestant, std::vector<int> ids, DetectIds detect) {
  std::sort(ids.begin(), ids.end());
  contestant.expected = contestant.found = ids.size();
  contestants_.push_back(std::move(contestant));
  expected_.push_back(std::move(ids));
  detect_.push_back(std::move(detect));
}

void Comparison::Round() {
  for (size_t i = 0; i < contestants_.size(); ++i) {
    StopWatch watch;
    const auto detect = [&] {
      watch.Lap();
      detect_[i](&ids_);
      return watch.Lap();
    };
    std::vector<double>& us = contestants_[i].us;
    const double first = detect();
    Check(i);
    if (first >= kLong) {
      us.push_back(first);
      continue;
    }
    double spent = 0;
    for (int n = 0; n < kMaxCounted && (n == 0 || spent < kTurn); ++n) {
      us.push_back(detect());
      spent += us.back();
    }
  }
}

void Comparison::Run(double seconds, int min_rounds, int max_rounds) {
  StopWatch watch;
  double spent = 0;
  for (int n = 0; n < max_rounds && (n < min_rounds || spent < 1e6 * seconds); ++n) {
    Round();
    spent += watch.Lap();
  }
}

void Comparison::Check(size_t i) {
  std::sort(ids_.begin(), ids_.end());
  std::vector<int> right;
  std::set_intersection(ids_.begin(), ids_.end(), expected_[i].begin(), expected_[i].end(),
                        std::back_inserter(right));
  contestants_[i].found = std::min(contestants_[i].found, right.size());
  contestants_[i].wrong = std::max(contestants_[i].wrong, ids_.size() - right.size());
}

}  // namespace topotag::bench
