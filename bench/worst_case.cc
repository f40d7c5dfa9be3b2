// Time and memory of the worst frames there are, as a function of their size; and the search that
// found them: an evolution of pictures that are made from a few numbers (tests/worst_picture.h).
//   worst_case [--options NAME] [--picture NUMBERS] [--quick] [--format text|json]
//   worst_case --search SECONDS [--goal time|memory] [--seed 1] [--size 640x480] [--options NAME]
// Time is the thread's own, the least of some frames; memory is what the detector has asked for.
// A search tries the same pictures in the same order for the same seed, as far as it gets and as
// far as times agree on which is the worse.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/command.h"
#include "tests/live_bytes.h"
#include "tests/thread_time.h"
#include "tests/worst_picture.h"
#include "topotag/detector.h"

namespace topotag::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kPopulation = 16;
constexpr double kEnough = 1000;  // milliseconds of one picture's frames

struct Arguments {
  std::string options = "each";
  std::string picture;
  double search = 0;
  std::string goal = "time";
  uint64_t seed = 1;
  std::vector<int> size = {640, 480};
  bool quick = false;
  std::string format = "text";
};

struct Cost {
  double ms = 0;
  double bytes = 0;
  size_t markers = 0;
};

double Milliseconds() { return ThreadSeconds() * 1e3; }

/// Of a detector that sees nothing else.
Cost CostOf(const WorstPicture& picture, const std::string& options, int width, int height,
            int frames) {
  const PaddedImage image = picture.Draw(width, height);
  std::vector<Detection> detections;
  detections.reserve(1 << 16);
  const PeakBytes peak;
  Detector detector(WorstOptions(options, width, height));
  Cost cost;
  for (int i = 0; i < frames && (i == 0 || i * cost.ms < kEnough); ++i) {
    const double begin = Milliseconds();
    detector.detect(image.view(), &detections);
    const double ms = Milliseconds() - begin;
    cost.ms = i == 0 ? ms : std::min(cost.ms, ms);
  }
  cost.bytes = static_cast<double>(peak.Get());
  cost.markers = detections.size();
  return cost;
}

struct Individual {
  WorstPicture picture;
  Cost cost;
};

struct IsMilder {
  bool by_time;
  bool operator()(const Individual& a, const Individual& b) const {
    return by_time ? a.cost.ms < b.cost.ms : a.cost.bytes < b.cost.bytes;
  }
};

/// Evolution: the child of two good ones takes the place of the mildest where it is worse.
class Search {
 public:
  Search(const Arguments& arguments, std::string options)
      : arguments_(arguments),
        options_(std::move(options)),
        is_milder_{arguments.goal == "time"},
        random_(arguments.seed) {}

  Individual Run() {
    const double end = Milliseconds() + arguments_.search * 1e3;
    while (all_.size() < kPopulation && (all_.empty() || Milliseconds() < end)) {
      all_.push_back(Judged(WorstPicture::Made(&random_)));
    }
    while (Milliseconds() < end) {
      Individual child = Judged(Child());
      const auto mildest = std::min_element(all_.begin(), all_.end(), is_milder_);
      if (is_milder_(*mildest, child)) *mildest = child;
    }
    return *std::max_element(all_.begin(), all_.end(), is_milder_);
  }
  int tried() const { return tried_; }

 private:
  Individual Judged(const WorstPicture& picture) {
    ++tried_;
    return {picture, CostOf(picture, options_, arguments_.size[0], arguments_.size[1], 2)};
  }
  // The worst of three.
  const WorstPicture& Parent() {
    const Individual* parent = nullptr;
    for (int i = 0; i < 3; ++i) {
      const Individual& one =
          all_[static_cast<size_t>(random_.Below(static_cast<int>(all_.size())))];
      if (parent == nullptr || is_milder_(*parent, one)) parent = &one;
    }
    return parent->picture;
  }
  WorstPicture Child() {
    if (random_.Chance(10)) return WorstPicture::Made(&random_);
    WorstPicture child = Parent();
    if (random_.Chance(40)) child = WorstPicture::Mixed(child, Parent(), &random_);
    for (int changes = random_.Between(1, 3); changes > 0; --changes) {
      child.Change(random_.Below(WorstPicture::kGenes), &random_);
    }
    return child;
  }

  const Arguments& arguments_;
  const std::string options_;
  const IsMilder is_milder_;
  Random random_;
  std::vector<Individual> all_;
  int tried_ = 0;
};

/// Least squares: y = at_zero + slope * x.
struct Line {
  double at_zero = 0, slope = 0;
};
Line Fit(const std::vector<double>& x, const std::vector<double>& y) {
  const double n = static_cast<double>(x.size());
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    sx += x[i], sy += y[i], sxx += x[i] * x[i], sxy += x[i] * y[i];
  }
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {(sy - slope * sx) / n, slope};
}

/// One picture with one set of options, at all sizes.
Json Sizes(const KnownWorst& known, bool quick) {
  using SizesOfFrames = std::vector<std::pair<int, int>>;
  const SizesOfFrames sizes =
      quick ? SizesOfFrames{{320, 240}, {640, 480}}
            : SizesOfFrames{{640, 480}, {1280, 960}, {1600, 1200}, {2592, 1944}, {3264, 2448}};
  const WorstPicture picture = WorstPicture::Parse(known.picture);
  Json json{{"options", known.options}, {"picture", known.picture}};
  std::vector<double> pixels, ms;
  double bytes_per_pixel = 0;
  for (const auto& [width, height] : sizes) {
    const Cost cost = CostOf(picture, known.options, width, height, quick ? 2 : 5);
    pixels.push_back(width * height * 1e-6);
    ms.push_back(cost.ms);
    bytes_per_pixel = std::max(bytes_per_pixel, cost.bytes / (width * height));
    json["sizes"].push_back({{"width", width},
                             {"height", height},
                             {"ms", cost.ms},
                             {"ms_per_mpx", cost.ms / pixels.back()},
                             {"bytes_per_px", cost.bytes / (width * height)},
                             {"markers", cost.markers}});
  }
  const Line line = Fit(pixels, ms);
  json["ms_fixed"] = line.at_zero;
  json["ms_per_mpx"] = line.slope;
  json["bytes_per_px"] = bytes_per_pixel;
  return json;
}

void PrintSizes(const Json& json) {
  std::printf("%-12s %6.1f ms + %6.1f ms/Mpx, %5.1f bytes/px  [%s]\n",
              json["options"].get<std::string>().c_str(), json["ms_fixed"].get<double>(),
              json["ms_per_mpx"].get<double>(), json["bytes_per_px"].get<double>(),
              json["picture"].get<std::string>().c_str());
  for (const Json& size : json["sizes"]) {
    std::printf("    %4dx%-4d %9.2f ms %8.2f ms/Mpx %6.1f bytes/px %6zu markers\n",
                size["width"].get<int>(), size["height"].get<int>(), size["ms"].get<double>(),
                size["ms_per_mpx"].get<double>(), size["bytes_per_px"].get<double>(),
                size["markers"].get<size_t>());
  }
}

Json Found(const Arguments& arguments, const std::string& options) {
  Search search(arguments, options);
  const Individual worst = search.Run();
  const double pixels = static_cast<double>(arguments.size[0]) * arguments.size[1];
  return {{"options", options},
          {"picture", worst.picture.Text()},
          {"tried", search.tried()},
          {"ms", worst.cost.ms},
          {"ms_per_mpx", worst.cost.ms / pixels * 1e6},
          {"bytes_per_px", worst.cost.bytes / pixels},
          {"markers", worst.cost.markers}};
}

void PrintFound(const Json& json) {
  std::printf("%-12s %8.2f ms %8.2f ms/Mpx %6.1f bytes/px %5zu markers, worst of %d  [%s]\n",
              json["options"].get<std::string>().c_str(), json["ms"].get<double>(),
              json["ms_per_mpx"].get<double>(), json["bytes_per_px"].get<double>(),
              json["markers"].get<size_t>(), json["tried"].get<int>(),
              json["picture"].get<std::string>().c_str());
}

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Time and memory of the worst frames.", "worst_case");
  std::vector<std::string> names = WorstOptionNames();
  names.push_back("each");
  app.add_option("--options", arguments.options, "A set of options (default: each)")
      ->check(CLI::IsMember(names));
  app.add_option("--picture", arguments.picture, "Of this one only, as a search prints it");
  app.add_option("--search", arguments.search, "Search for so many seconds with each set")
      ->check(CLI::Range(0.0, 1e6));
  app.add_option("--goal", arguments.goal, "Of a search: time or memory (default: time)")
      ->check(CLI::IsMember({"time", "memory"}));
  app.add_option("--seed", arguments.seed, "Of a search (default: 1)");
  app.add_option("--size", arguments.size, "Of a search, WIDTHxHEIGHT (default: 640x480)")
      ->delimiter('x')
      ->expected(2)
      ->check(CLI::Range(16, kMaxImageSide));
  app.add_flag("--quick", arguments.quick, "Two small sizes");
  AddFormat(&app, &arguments.format);
  CLI11_PARSE(app, argc, argv);
  const bool is_text = arguments.format == "text";
  Json report = Json::array();
  const auto add = [&](Json json, void (*print)(const Json&)) {
    if (is_text) print(json);
    std::fflush(stdout);
    report.push_back(std::move(json));
  };
  const auto is_wanted = [&](const std::string& name) {
    return arguments.options == "each" || arguments.options == name;
  };
  if (arguments.search > 0) {
    for (const std::string& name : WorstOptionNames()) {
      if (is_wanted(name)) add(Found(arguments, name), PrintFound);
    }
  } else if (!arguments.picture.empty()) {
    for (const std::string& name : WorstOptionNames()) {
      if (is_wanted(name)) add(Sizes({name, arguments.picture}, arguments.quick), PrintSizes);
    }
  } else {
    for (const KnownWorst& known : KnownWorstPictures()) {
      if (is_wanted(known.options)) add(Sizes(known, arguments.quick), PrintSizes);
    }
  }
  if (!is_text) std::printf("%s\n", report.dump(1).c_str());
  return 0;
}

}  // namespace
}  // namespace topotag::bench

int main(int argc, char** argv) {
  return topotag::bench::RunCommand("worst_case", topotag::bench::Main, argc, argv);
}
