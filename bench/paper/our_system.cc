#include <utility>

#include "bench/paper/resized.h"
#include "bench/paper/systems.h"

namespace topotag::bench::paper {
namespace {

class OurSystem : public System {
 public:
  OurSystem(std::string name, MarkerDesign design, const Options& options)
      : name_(std::move(name)),
        design_(std::move(design)),
        tag_size_(kMarkerSide * design_.family.white_side() /
                  (design_.family.white_side() + 2 * design_.frame)),
        far_(options.far),
        finder_(With(options, PoseMode::kVertices, false)),
        vertices_(With(options, PoseMode::kVertices, true)),
        photometric_(With(options, PoseMode::kPhotometric, true)) {}

  Who who() const override { return Who::kOurs; }
  std::string name() const override { return name_; }
  std::string description() const override {
    return std::string("TopoTag ") + Version() + (far_ ? ", far on" : ", default options");
  }
  uint64_t dictionary_size() const override { return design_.family.size(); }
  std::vector<std::string> solvers() const override { return {"photometric", "vertices"}; }
  double core_side() const override { return tag_size_; }

  Image Render(const Scene& scene, uint64_t id) const override {
    return RenderScene(Placed(scene, id));
  }

  std::vector<Point2> TruePoints(const Scene& scene) const override {
    const VertexList vertices = GroundTruth(Placed(scene, 0), 0).vertices;
    return {vertices.begin(), vertices.end()};
  }

  void Find(const ImageView& frame, std::vector<Seen>* markers) override {
    Look(&finder_, frame, markers);
  }

  void Locate(const ImageView& frame, std::vector<Seen>* markers) override {
    Look(&vertices_, frame, markers);
    for (size_t i = 0; i < markers->size(); ++i) {
      Detection& detection = found_[i];
      std::vector<std::optional<PoseSolution>>& poses = (*markers)[i].poses;
      poses.assign(2, std::nullopt);
      if (!detection.pose) continue;
      poses[1] = *detection.pose;
      vertices_.refine(frame, &detection);
      poses[0] = *detection.pose;
    }
  }

  int Run(const ImageView& frame, size_t solver) override {
    (solver == 0 ? photometric_ : vertices_).detect(frame, &found_);
    return static_cast<int>(found_.size());
  }

 private:
  Options With(Options options, PoseMode mode, bool poses) const {
    options.families = {design_.family};
    options.threads = 1;
    options.pose = mode;
    if (poses) {
      options.camera = PaperCamera();
      options.tag_size = tag_size_;
    }
    return options;
  }

  Scene Placed(const Scene& scene, uint64_t id) const {
    MarkerDesign design = design_;
    design.id = id;
    return WithDesign(scene, design, tag_size_);
  }

  void Look(Detector* detector, const ImageView& frame, std::vector<Seen>* markers) {
    detector->detect(frame, &found_);
    markers->clear();
    for (const Detection& detection : found_) {
      const VertexList& vertices = detection.vertices;
      markers->push_back({detection.id, detection.corners, {vertices.begin(), vertices.end()}, {}});
    }
  }

  std::string name_;
  MarkerDesign design_;
  double tag_size_;
  bool far_;
  Detector finder_, vertices_, photometric_;
  std::vector<Detection> found_;
};

}  // namespace

std::unique_ptr<System> MakeOurs(const std::string& name, const MarkerDesign& design,
                                 const Options& options) {
  return std::make_unique<OurSystem>(name, design, options);
}

Systems MakeOurs() {
  Options options;
  options.far = true;
  Systems systems;
  for (const int n : {3, 4, 5}) {
    MarkerDesign design;
    design.family = Family(n);
    systems.push_back(MakeOurs("TopoTag " + design.family.name(), design, options));
  }
  return systems;
}

}  // namespace topotag::bench::paper
