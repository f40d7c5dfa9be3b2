#include <array>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bench/paper/published.h"
#include "bench/paper/trials.h"

namespace topotag::bench::paper {
namespace {

constexpr double kDistance = 0.25;  // metres
constexpr double kSide = 19;        // of the marker with its frame, units of PaperScene
constexpr double kReach = 13;       // of a card, from the marker's centre, the same
const double kTilts[] = {0, 30, 45};
const double kLevels[] = {40, 120, 200};
constexpr int kIdsInUse = 20;

/// From where the marker is covered.
struct Side {
  const char* id;
  const char* title;
};
constexpr Side kSides[] = {
    {"top", "Covered from the top or the left, where ours have the baseline node"},
    {"bottom", "Covered from the bottom or the right"},
    {"both", "Covered from two opposite sides, half of it from each"},
};
constexpr size_t kSideCount = 3;

/// A card over `share` of the whole marker, from one of its sides: 0 top, 1 left, 2 bottom,
/// 3 right.
Occluder Card(int side, double share, double level) {
  const double in = (share - 0.5) * kSide;
  Occluder card{{{-kReach, -kReach}, {kReach, -kReach}, {kReach, in}, {-kReach, in}}, level, 0};
  for (Point2& p : card.outline) {
    if (side % 2 == 1) std::swap(p.x, p.y);
    if (side >= 2) p = {-p.x, -p.y};
  }
  return card;
}

/// @param side  of kSides.
Scene CoveredScene(size_t side, int percent, int frame) {
  Scene scene = FreeView(kDistance, kTilts[frame % 3], 1 + static_cast<uint64_t>(frame));
  const double level = kLevels[frame / 3 % 3], share = percent / 100.0;
  const int way = frame % 2;
  if (side == 0) scene.occluders = {Card(way, share, level)};
  if (side == 1) scene.occluders = {Card(way + 2, share, level)};
  if (side == 2) {
    scene.occluders = {Card(way, share / 2, level), Card(way + 2, share / 2, level)};
  }
  return scene;
}

/// One way to read covered markers.
struct Reader {
  Who who;
  std::string name;
  std::shared_ptr<System> system;  ///< renders
  std::function<Tally(const Scene&, const ImageView&, uint64_t id)> read;
};

Reader PlainReader(const std::shared_ptr<System>& system, const std::string& name) {
  const auto seen = std::make_shared<std::vector<Seen>>();
  return {system->who(), name, system,
          [system, seen](const Scene& scene, const ImageView& frame, uint64_t id) {
            system->Find(frame, seen.get());
            return Judge(scene, id, *seen);
          }};
}

/// With Options::hidden_nodes: what counts is that all bits that are known are right.
/// @param more  the other options.
Reader HiddenReader(const std::shared_ptr<System>& system, const std::string& name,
                    const MarkerDesign& design, Options more) {
  more.far = true;
  more.threads = 1;
  more.families = {design.family};
  more.hidden_nodes = kMaxVertices;
  const auto detector = std::make_shared<Detector>(more);
  return {Who::kOurs, name, system,
          [detector](const Scene& scene, const ImageView& frame, uint64_t id) {
            std::vector<Seen> seen;
            for (const Detection& found : detector->detect(frame)) {
              // In place of the bits that are not known, the true ones.
              const uint64_t whole = found.id | (id & found.unknown_bits);
              seen.push_back({whole, found.corners, {}, {}});
            }
            return Judge(scene, id, seen);
          }};
}

/// Options::ids of the first kIdsInUse seeds, which are those of the frames.
Options KnownIds(const System& system, Family family) {
  std::set<uint64_t> ids;
  for (uint64_t seed = 1; seed <= kIdsInUse; ++seed) ids.insert(system.IdFor(seed));
  Options options;
  options.ids[family.n()] = {ids.begin(), ids.end()};
  return options;
}

std::vector<Reader> MakeReaders() {
  std::vector<Reader> plain, hidden, known;
  Options options;
  options.far = true;
  for (const int n : {3, 4, 5}) {
    MarkerDesign design;
    design.family = Family(n);
    const std::shared_ptr<System> system =
        MakeOurs("TopoTag " + design.family.name(), design, options);
    plain.push_back(PlainReader(system, system->name()));
    hidden.push_back(HiddenReader(system, system->name() + " hidden nodes", design, {}));
    known.push_back(HiddenReader(system, system->name() + " hidden nodes, known IDs", design,
                                 KnownIds(*system, design.family)));
  }
  plain.insert(plain.end(), hidden.begin(), hidden.end());
  plain.insert(plain.end(), known.begin(), known.end());
  for (auto& peer : MakePeerSystems()) {
    const std::string name = peer->name();
    plain.push_back(PlainReader(std::move(peer), name));
  }
  return plain;
}

/// One reader's of each side and share: [side][share].
using Tallies = std::array<std::vector<Tally>, kSideCount>;

/// In what frames the markers are covered.
struct Cover {
  std::vector<int> shares;  ///< %
  int frames = 0;           ///< of each side and share
};

/// Where a frame stands among all of ReadAll.
struct Place {
  size_t reader, side, share;
  int frame;
};

Place PlaceOf(int index, const Cover& cover) {
  const int shares = static_cast<int>(cover.shares.size());
  const int cell = index / cover.frames;
  return {static_cast<size_t>(cell / shares / static_cast<int>(kSideCount)),
          static_cast<size_t>(cell / shares % static_cast<int>(kSideCount)),
          static_cast<size_t>(cell % shares), index % cover.frames};
}

std::vector<Tallies> ReadAll(const Context& context, const Cover& cover,
                             const std::vector<std::vector<Reader>>& workers,
                             std::vector<std::string>* broken) {
  const size_t readers = workers[0].size(), shares = cover.shares.size();
  const int count = static_cast<int>(readers * kSideCount * shares) * cover.frames;
  std::vector<Tally> tallies(static_cast<size_t>(count));
  context.progress->SetSteps(count);
  ForEachFrame(context, count, [&](int index, int worker) {
    const Place place = PlaceOf(index, cover);
    const Reader& reader = workers[static_cast<size_t>(worker)][place.reader];
    const Scene scene = CoveredScene(place.side, cover.shares[place.share], place.frame);
    const uint64_t id = reader.system->IdFor(scene.seed);
    const Image image = reader.system->Render(scene, id);
    tallies[static_cast<size_t>(index)] = reader.read(scene, image.view(), id);
  });
  Tallies none;
  none.fill(std::vector<Tally>(shares));
  std::vector<Tallies> sums(readers, none);
  for (int index = 0; index < count; ++index) {
    const Place place = PlaceOf(index, cover);
    const Tally& tally = tallies[static_cast<size_t>(index)];
    sums[place.reader][place.side][place.share].Add(tally);
    const Reader& reader = workers[0][place.reader];
    if (reader.who != Who::kOurs || tally.wrong == 0) continue;
    broken->push_back(reader.name + ": wrong detection, " +
                      std::to_string(cover.shares[place.share]) + " % from " +
                      kSides[place.side].id + ", frame " + std::to_string(place.frame));
  }
  return sums;
}

/// Largest share up to which every frame was read, %.
int Limit(const Cover& cover, const std::vector<Tally>& tallies) {
  int limit = 0;
  for (size_t share = 0; share < cover.shares.size(); ++share) {
    if (tallies[share].found < tallies[share].frames) break;
    limit = cover.shares[share];
  }
  return limit;
}

Table LimitTable(const Cover& cover, const std::vector<Reader>& readers,
                 const std::vector<Tallies>& sums) {
  Table table{"occlusion_limit",
              "Largest of the shares up to which all frames were read, %",
              {{"top or left", Better::kHigher},
               {"bottom or right", Better::kHigher},
               {"both sides", Better::kHigher}},
              PublishedRows({&Published::max_occlusion}),
              "The paper does not say which side; its figure stands in the first column."};
  for (Row& row : table.rows) row.cells.resize(table.columns.size());
  for (size_t i = 0; i < readers.size(); ++i) {
    Row row{readers[i].who, readers[i].name, {}};
    for (const auto& tallies : sums[i]) row.cells.push_back(Number(Limit(cover, tallies), 0));
    table.rows.push_back(row);
  }
  return table;
}

Table SideTable(const Cover& cover, size_t side, const std::vector<Reader>& readers,
                const std::vector<Tallies>& sums) {
  Table table{std::string("occlusion_") + kSides[side].id, kSides[side].title, {}, {}, ""};
  for (const int share : cover.shares) {
    table.columns.push_back({std::to_string(share) + " %", Better::kHigher});
  }
  table.columns.push_back({"precision", Better::kHigher});
  for (size_t i = 0; i < readers.size(); ++i) {
    Row row{readers[i].who, readers[i].name, {}};
    Tally all;
    for (const Tally& tally : sums[i][side]) {
      row.cells.push_back(Percent(tally.found, tally.frames));
      all.Add(tally);
    }
    row.cells.push_back(Percent(all.found, all.found + all.wrong));
    table.rows.push_back(row);
  }
  return table;
}

Json Data(const Cover& cover, const std::vector<Reader>& readers,
          const std::vector<Tallies>& sums) {
  Json data = Json::object();
  for (size_t side = 0; side < kSideCount; ++side) {
    for (size_t share = 0; share < cover.shares.size(); ++share) {
      Json& cell = data[kSides[side].id][std::to_string(cover.shares[share])];
      for (size_t i = 0; i < readers.size(); ++i) {
        const Tally& tally = sums[i][side][share];
        cell[readers[i].name] = {
            {"frames", tally.frames}, {"found", tally.found}, {"wrong", tally.wrong}};
      }
    }
  }
  return data;
}

}  // namespace

Section MeasureOcclusion(const Context& context) {
  Section section;
  section.id = "occlusion";
  section.title = "Occlusion";
  const Cover cover{context.quick ? std::vector<int>{10, 40} : std::vector<int>{10, 20, 30, 40},
                    context.Frames(12, 1)};
  std::vector<std::vector<Reader>> workers;
  for (int worker = 0; worker < context.threads; ++worker) workers.push_back(MakeReaders());
  const std::vector<Reader>& readers = workers[0];
  const std::vector<Tallies> sums = ReadAll(context, cover, workers, &section.broken);
  section.paragraphs = {
      "A card with a straight edge covers 10 to 40 % of the marker's 5 cm, the same card for all "
      "systems, and hides what lies beyond on that side. 10 % is about the border that belongs to "
      "each marker (ours: the frame and the gap before the nodes). For each share and side " +
          FramesText(cover.frames) +
          ": 0.25 m, tilted by 0, 30 and 45 degrees, dark, grey and light cards, turn and place at "
          "random.",
      "Hidden nodes: ours with that option, all others as they are; a marker counts as found where "
      "all of its known bits are right, and the nodes that are covered remain unknown. Known IDs: "
      "the same, and ours are told " +
          std::to_string(kIdsInUse) +
          " IDs in use, of which the only one that fits is given, whole. The peers have redundancy "
          "in their dictionaries for that."};
  section.tables.push_back(LimitTable(cover, readers, sums));
  for (size_t side = 0; side < kSideCount; ++side) {
    section.tables.push_back(SideTable(cover, side, readers, sums));
  }
  for (size_t side = 0; side < kSideCount; ++side) {
    const System& system = *readers[1].system;
    const int share = 10 * static_cast<int>(side + 1), frame = 4 * static_cast<int>(side);
    section.pictures.push_back(PictureOf(std::to_string(share) + " %, " + kSides[side].id,
                                         CoveredScene(side, share, frame), system));
  }
  section.data = Data(cover, readers, sums);
  return section;
}

}  // namespace topotag::bench::paper
