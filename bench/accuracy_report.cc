#include "bench/accuracy_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "tests/scene_util.h"

namespace topotag::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kChiSquare95 = 12.591587;  // of 6 degrees of freedom
constexpr double kMaxBoundRatio = 1.5;
constexpr double kMaxPeerRatio = 0.5;
constexpr double kMaxMeanPeerRatio = 0.2;

/// What is compared: position or rotation.
struct Quantity {
  const char* name;
  const char* unit;
  double scale;  // units per metre or radian
  double PoseError::*error;
  double PoseBound::*median_bound;
  double PoseBound::*rms_bound;
};
constexpr Quantity kQuantities[] = {{"position", "mm", 1e3, &PoseError::position,
                                     &PoseBound::median_position, &PoseBound::rms_position},
                                    {"rotation", "degrees", 1 / test::kDegree, &PoseError::rotation,
                                     &PoseBound::median_rotation, &PoseBound::rms_rotation}};

Json Median(std::vector<double> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

Json Ratio(const Json& a, const Json& b) {
  if (a.is_null() || b.is_null()) return nullptr;
  return a.get<double>() / b.get<double>();
}

/// Of the family of the first system that is not ours: the best of its ways to a pose.
Json BestPeer(const AccuracyCell& cell, const Json& errors) {
  Json best;
  std::string peer;
  for (const PoseErrors& system : cell.systems) {
    if (system.ours) continue;
    const std::string name = system.name.substr(0, system.name.rfind(' '));
    if (peer.empty()) peer = name;
    const Json& median = errors[system.name]["median"];
    if (name != peer || median.is_null()) continue;
    if (best.is_null() || median < best) best = median;
  }
  return best;
}

Json Summarize(const AccuracyCell& cell, const Quantity& quantity) {
  Json json;
  std::vector<double> medians, rms;
  for (const PoseBound& bound : cell.bounds) {
    medians.push_back(bound.*quantity.median_bound * quantity.scale);
    rms.push_back(bound.*quantity.rms_bound * quantity.scale);
  }
  json["bound_median"] = Median(medians);
  json["bound_rms"] = Median(rms);
  for (const PoseErrors& system : cell.systems) {
    std::vector<double> errors, ratios;
    for (size_t i = 0; i < system.frames.size(); ++i) {
      if (!system.frames[i]) continue;
      errors.push_back(*system.frames[i].*quantity.error * quantity.scale);
      ratios.push_back(errors.back() / medians[i]);
    }
    Json& entry = json["systems"][system.name];
    entry["median"] = Median(errors);
    // Of the ratios, not the ratio of the medians: the bounds differ from frame to frame.
    if (system.ours) entry["to_bound"] = Median(ratios);
  }
  json["best_peer"] = BestPeer(cell, json["systems"]);
  for (const PoseErrors& system : cell.systems) {
    Json& entry = json["systems"][system.name];
    if (system.ours) entry["to_best_peer"] = Ratio(entry["median"], json["best_peer"]);
  }
  return json;
}

Json SummarizeCovariance(const PoseErrors& system) {
  double sum = 0;
  size_t count = 0, inside = 0;
  std::vector<double> values;
  for (const auto& error : system.frames) {
    if (!error) continue;
    sum += error->mahalanobis2;
    inside += error->mahalanobis2 < kChiSquare95;
    values.push_back(error->mahalanobis2 / 6);
    ++count;
  }
  if (count == 0) return nullptr;
  const double n = static_cast<double>(count);
  return {{"mean_mahalanobis2_per_6", sum / n / 6},
          {"median_mahalanobis2_per_6", Median(values)},
          {"coverage_95", static_cast<double>(inside) / n}};
}

std::vector<std::string> Ours(const Json& cell) {
  std::vector<std::string> names;
  for (const auto& item : cell["position"]["systems"].items()) {
    if (item.value().contains("to_bound")) names.push_back(item.key());
  }
  return names;
}

/// Geometric mean of one of our ratios over all cells.
Json MeanRatio(const Json& cells, const std::string& quantity, const std::string& system,
               const char* ratio) {
  double sum = 0;
  int count = 0;
  for (const Json& cell : cells) {
    const Json& value = cell[quantity]["systems"][system][ratio];
    if (value.is_null()) continue;
    sum += std::log(value.get<double>());
    ++count;
  }
  if (count == 0) return nullptr;
  return std::exp(sum / count);
}

std::string CellName(const Json& cell) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f m, %2.0f deg", cell["distance"].get<double>(),
                cell["tilt"].get<double>());
  return text;
}

Json FindMisses(const Json& cells) {
  Json misses = Json::array();
  for (const Json& cell : cells) {
    const auto check = [&](const std::string& system, const Quantity& quantity, const char* ratio,
                           double limit) {
      const Json& value = cell[quantity.name]["systems"][system][ratio];
      if (value.is_null() || value <= limit) return;
      char text[160];
      std::snprintf(text, sizeof(text), "%s: %s of %s, %s %.2f > %.2f", CellName(cell).c_str(),
                    quantity.name, system.c_str(), ratio, value.get<double>(), limit);
      misses.push_back(text);
    };
    for (const std::string& system : Ours(cell)) {
      const bool photometric = system == "photometric";
      for (const Quantity& quantity : kQuantities) {
        if (photometric) check(system, quantity, "to_bound", kMaxBoundRatio);
        check(system, quantity, "to_best_peer", photometric ? kMaxPeerRatio : 1);
      }
      if (cell["found"][system] != cell["frames"]) {
        misses.push_back(CellName(cell) + ": " + system + " found " + cell["found"][system].dump() +
                         " of " + cell["frames"].dump());
      }
    }
  }
  return misses;
}

void AppendNumber(const Json& value, int width, int digits, std::string* text) {
  char number[32];
  if (value.is_null()) {
    std::snprintf(number, sizeof(number), "%*s", width, "-");
  } else {
    std::snprintf(number, sizeof(number), "%*.*f", width, digits, value.get<double>());
  }
  *text += number;
}

void AppendTitle(const std::string& title, int width, std::string* text) {
  text->append(static_cast<size_t>(std::max<int>(1, width - static_cast<int>(title.size()))), ' ');
  *text += title;
}

constexpr int kNameWidth = 15, kWidth = 12;

void AppendQuantity(const Json& summary, const Quantity& quantity, std::string* text) {
  const Json& cells = summary["cells"];
  const std::vector<std::string> ours = Ours(cells[0]);
  *text += std::string("\n") + quantity.name + ", " + quantity.unit + " (medians)\n";
  AppendTitle("", kNameWidth, text);
  AppendTitle("bound", kWidth, text);
  for (const std::string& system : ours) AppendTitle(system, kWidth, text);
  AppendTitle("best peer", kWidth, text);
  for (const std::string& system : ours) AppendTitle(system.substr(0, 5) + "/bound", kWidth, text);
  for (const std::string& system : ours) AppendTitle(system.substr(0, 5) + "/peer", kWidth, text);
  *text += "\n";
  for (const Json& cell : cells) {
    const Json& values = cell[quantity.name];
    AppendTitle(CellName(cell), kNameWidth, text);
    AppendNumber(values["bound_median"], kWidth, 5, text);
    for (const auto& s : ours) AppendNumber(values["systems"][s]["median"], kWidth, 5, text);
    AppendNumber(values["best_peer"], kWidth, 5, text);
    for (const char* ratio : {"to_bound", "to_best_peer"}) {
      for (const auto& s : ours) AppendNumber(values["systems"][s][ratio], kWidth, 3, text);
    }
    *text += "\n";
  }
  AppendTitle("geometric mean", kNameWidth, text);
  text->append(static_cast<size_t>(kWidth) * (ours.size() + 2), ' ');
  for (const char* ratio : {"to_bound", "to_best_peer"}) {
    for (const auto& s : ours) {
      AppendNumber(summary["means"][s][quantity.name][ratio], kWidth, 3, text);
    }
  }
  *text += "\n";
}

void AppendCounts(const Json& summary, std::string* text) {
  const Json& cells = summary["cells"];
  const std::vector<std::string> ours = Ours(cells[0]);
  *text +=
      "\nfound; reported covariance: mean squared Mahalanobis distance / 6 (should be 1), "
      "share within 95 %\n";
  AppendTitle("", kNameWidth, text);
  for (const auto& item : cells[0]["found"].items()) {
    if (item.key().find("IPPE") == std::string::npos) AppendTitle(item.key(), 15, text);
  }
  for (const auto& s : ours) {
    AppendTitle(s.substr(0, 5) + " d2/6", kWidth, text);
    AppendTitle(s.substr(0, 5) + " 95 %", kWidth, text);
  }
  *text += "\n";
  for (const Json& cell : cells) {
    AppendTitle(CellName(cell), kNameWidth, text);
    for (const auto& item : cell["found"].items()) {
      if (item.key().find("IPPE") != std::string::npos) continue;
      AppendTitle(item.value().dump() + "/" + cell["frames"].dump(), 15, text);
    }
    for (const auto& s : ours) {
      const Json covariance = cell["covariance"].value(s, Json());
      const bool none = covariance.is_null();
      AppendNumber(none ? Json() : covariance["mean_mahalanobis2_per_6"], kWidth, 2, text);
      AppendNumber(none ? Json() : covariance["coverage_95"], kWidth, 2, text);
    }
    *text += "\n";
  }
}

}  // namespace

Json SummarizeAccuracy(const std::vector<AccuracyCell>& cells) {
  Json summary;
  std::map<std::string, PoseErrors> all;
  for (const AccuracyCell& cell : cells) {
    Json entry;
    entry["distance"] = cell.view.distance;
    entry["tilt"] = cell.view.tilt;
    entry["frames"] = cell.bounds.size();
    for (const PoseErrors& system : cell.systems) {
      size_t found = 0;
      for (const auto& error : system.frames) found += error.has_value();
      entry["found"][system.name] = found;
      if (!system.ours) continue;
      entry["covariance"][system.name] = SummarizeCovariance(system);
      std::vector<std::optional<PoseError>>& frames = all[system.name].frames;
      frames.insert(frames.end(), system.frames.begin(), system.frames.end());
    }
    for (const Quantity& quantity : kQuantities) {
      entry[quantity.name] = Summarize(cell, quantity);
    }
    summary["cells"].push_back(std::move(entry));
  }
  for (const std::string& system : Ours(summary["cells"][0])) {
    for (const Quantity& quantity : kQuantities) {
      for (const char* ratio : {"to_bound", "to_best_peer"}) {
        summary["means"][system][quantity.name][ratio] =
            MeanRatio(summary["cells"], quantity.name, system, ratio);
      }
    }
    summary["covariance"][system] = SummarizeCovariance(all[system]);
  }
  summary["misses"] = FindMisses(summary["cells"]);
  for (const Quantity& quantity : kQuantities) {
    if (!summary["means"].contains("photometric")) break;
    const Json& mean = summary["means"]["photometric"][quantity.name]["to_best_peer"];
    if (mean.is_null() || mean <= kMaxMeanPeerRatio) continue;
    summary["misses"].push_back(std::string("geometric mean: ") + quantity.name +
                                " of photometric, to_best_peer " + mean.dump());
  }
  return summary;
}

std::string AccuracyTables(const Json& summary) {
  std::string text;
  for (const Quantity& quantity : kQuantities) AppendQuantity(summary, quantity, &text);
  AppendCounts(summary, &text);
  text += "\nall cells:\n";
  for (const auto& item : summary["covariance"].items()) {
    text += "  " + item.key() + ": " + item.value().dump() + "\n";
  }
  text += "photometric step at 60 px of side, us (target 60): " +
          summary.value("photometric_us_at_60_px", Json()).dump() + "\n";
  text += "\ntargets missed: " + std::to_string(summary["misses"].size()) + "\n";
  for (const Json& miss : summary["misses"]) text += "  " + miss.get<std::string>() + "\n";
  return text;
}

}  // namespace topotag::bench
