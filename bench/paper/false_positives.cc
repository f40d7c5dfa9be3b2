#include <string>
#include <utility>
#include <vector>

#include "bench/paper/context.h"
#include "bench/paper/published.h"
#include "bench/paper/systems.h"
#include "topotag/error.h"
#ifdef TOPOTAG_BENCH_WITH_FILES
#include "topotag/image_file.h"
#endif

namespace topotag::bench::paper {
namespace {

constexpr size_t kQuickPhotos = 6;

/// Ours on whole photographs, whose cameras are not known: all families of a detector at once.
struct OurSearch {
  std::string name;
  Options options;
};

std::vector<OurSearch> OurSearches() {
  OurSearch usual{"TopoTag 3x3, 4x4, 5x5", {}};
  OurSearch all{"TopoTag 3x3 to 8x8, every option on", {}};
  all.options.families.clear();
  for (int n = Family::kMinN; n <= Family::kMaxN; ++n) all.options.families.emplace_back(n);
  all.options.far = true;
  all.options.hidden_nodes = kMaxVertices;
  all.options.pose = PoseMode::kPhotometric;
  usual.options.threads = all.options.threads = 1;
  OurSearch smoothed = all;
  smoothed.name += ", pre-blur";
  smoothed.options.pre_blur = true;
  return {usual, all, smoothed};
}

/// What one thread looks with.
struct Worker {
  std::vector<Detector> ours;
  Systems peers = MakePeerSystems();
  std::vector<Detection> detections;
  std::vector<Seen> seen;
};

/// Detections in one photograph, a number for each system.
std::vector<int> Look(const ImageView& photo, Worker* worker) {
  std::vector<int> counts;
  for (Detector& detector : worker->ours) {
    detector.detect(photo, &worker->detections);
    counts.push_back(static_cast<int>(worker->detections.size()));
  }
  for (const auto& peer : worker->peers) {
    peer->Find(photo, &worker->seen);
    counts.push_back(static_cast<int>(worker->seen.size()));
  }
  return counts;
}

#ifdef TOPOTAG_BENCH_WITH_FILES
std::vector<std::string> ListPhotos(const Context& context) {
  std::vector<std::string> files = ListImages(context.photos_folder);
  if (!context.quick || files.size() <= kQuickPhotos) return files;
  std::vector<std::string> few;
  for (size_t i = 0; i < kQuickPhotos; ++i) few.push_back(files[i * files.size() / kQuickPhotos]);
  return few;
}
#else
std::vector<std::string> ListPhotos(const Context& context) {
  throw Error(ErrorCode::kUnavailable, context.photos_folder + ": this build reads no files");
}
Image ReadImage(const std::string& /*path*/) { return {}; }
#endif

struct Counts {
  std::vector<std::string> files;
  std::vector<std::vector<int>> detections;  ///< [photograph][system]
};

Counts CountAll(const Context& context) {
  Counts counts;
  counts.files = ListPhotos(context);
  counts.detections.resize(counts.files.size());
  std::vector<Worker> workers(static_cast<size_t>(context.threads));
  for (Worker& worker : workers) {
    for (const OurSearch& search : OurSearches()) worker.ours.emplace_back(search.options);
  }
  const int count = static_cast<int>(counts.files.size());
  context.progress->SetSteps(count);
  ForEachFrame(context, count, [&](int index, int worker) {
    const Image photo = ReadImage(counts.files[static_cast<size_t>(index)]);
    counts.detections[static_cast<size_t>(index)] =
        Look(photo.view(), &workers[static_cast<size_t>(worker)]);
  });
  return counts;
}

/// The row of system `which`, and its figures for the JSON.
Row CountRow(const Counts& counts, size_t which, Who who, const std::string& name, Json* data) {
  int photos = 0, detections = 0;
  Json named = Json::array();
  for (size_t i = 0; i < counts.files.size(); ++i) {
    const int found = counts.detections[i][which];
    detections += found;
    if (found == 0) continue;
    ++photos;
    named.push_back(counts.files[i].substr(counts.files[i].rfind('/') + 1));
  }
  (*data)[name] = {{"photographs", photos}, {"detections", detections}, {"names", named}};
  return {who, name, {Number(detections, 0), Number(photos, 0)}};
}

Table MakeTable(const Counts& counts, Json* data) {
  Table table{"false_positives",
              "Detections where there is no marker",
              {{"detections", Better::kLower}, {"photographs with any", Better::kLower}},
              PublishedRows({&Published::false_positives}),
              "Rows of the paper: on 207,883 photographs of LabelMe."};
  for (Row& row : table.rows) row.cells.resize(table.columns.size());
  size_t which = 0;
  for (const OurSearch& search : OurSearches()) {
    table.rows.push_back(CountRow(counts, which++, Who::kOurs, search.name, data));
  }
  for (const auto& peer : MakePeerSystems()) {
    table.rows.push_back(CountRow(counts, which++, Who::kPeer, peer->name(), data));
  }
  return table;
}

}  // namespace

Section MeasureFalsePositives(const Context& context) {
  Section section;
  section.id = "false-positives";
  section.title = "False positives on photographs";
  if (context.photos_folder.empty()) {
    section.paragraphs = {
        "Not run: no folder of photographs without markers was named (--photos FOLDER)."};
    section.data["photographs"] = 0;
    return section;
  }
  const Counts counts = CountAll(context);
  const std::string number = std::to_string(counts.files.size());
  section.data["photographs"] = counts.files.size();
  section.paragraphs = {
      (context.quick ? number + " photographs of the folder named, spread over it"
                     : "All " + number + " photographs of the folder named") +
      ", in their own sizes; none of them is meant to show a marker of any system. Ours look for "
      "three families with default options, and for all six with everything on that finds more "
      "(far, hidden nodes, photometric poses), without and with the smoothing of pre-blur."};
  section.tables = {MakeTable(counts, &section.data["systems"])};
  for (size_t which = 0; which < OurSearches().size(); ++which) {
    for (size_t i = 0; i < counts.files.size(); ++i) {
      if (counts.detections[i][which] == 0) continue;
      section.broken.push_back(OurSearches()[which].name + ": detection in " + counts.files[i]);
    }
  }
  return section;
}

}  // namespace topotag::bench::paper
