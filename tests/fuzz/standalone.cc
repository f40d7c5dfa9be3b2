// Runs a fuzz target where there is no libFuzzer: over its seeds and mutations of them, the same
// ones on every machine. Also writes the seeds with which libFuzzer begins, and repeats findings.
//   fuzz_TARGET_runs MUTATIONS | --seeds FOLDER | FILE...

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "host/file.h"
#include "tests/fuzz/target.h"

namespace topotag::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxInput = size_t{1} << 20;

class Mutator {
 public:
  explicit Mutator(const std::vector<std::string>& seeds) : seeds_(seeds) {}

  std::string Next() {
    std::string bytes = Seed();
    for (size_t count = size_t{1} << Below(4); count > 0; --count) Mutate(&bytes);
    return bytes;
  }

 private:
  size_t Below(size_t n) { return static_cast<size_t>(random_() % n); }
  const std::string& Seed() { return seeds_[Below(seeds_.size())]; }
  std::string Piece(const std::string& bytes) {
    const size_t begin = Below(bytes.size() + 1);
    return bytes.substr(begin, Below(std::min<size_t>(bytes.size() - begin, 64) + 1));
  }

  void Mutate(std::string* bytes) {
    static constexpr unsigned char kEdges[] = {0x00, 0x01, 0x7f, 0x80, 0xff, '-', '0', '9', '\n'};
    const size_t at = Below(bytes->size() + 1);
    const size_t kind = Below(7);
    if (kind == 0) bytes->insert(at, Piece(*bytes));
    if (kind == 1) bytes->insert(at, Piece(Seed()));
    if (kind == 2) bytes->insert(at, 1, static_cast<char>(Below(256)));
    if (at == bytes->size()) return;
    if (kind == 3) bytes->erase(at, 1 + Below(16));
    if (kind == 4) (*bytes)[at] = static_cast<char>((*bytes)[at] ^ (1 << Below(8)));
    if (kind == 5) (*bytes)[at] = static_cast<char>(kEdges[Below(sizeof(kEdges))]);
    if (kind == 6) (*bytes)[at] = static_cast<char>(Below(256));
  }

  const std::vector<std::string>& seeds_;
  std::mt19937_64 random_{1};
};

void Run(const std::string& bytes) {
  // A copy of the very size: what reads behind it reads behind an allocation.
  const std::vector<uint8_t> input(bytes.begin(), bytes.end());
  LLVMFuzzerTestOneInput(input.data(), input.size());
}

void WriteSeeds(const fs::path& folder) {
  fs::create_directories(folder);
  const std::vector<std::string> seeds = Seeds();
  for (size_t i = 0; i < seeds.size(); ++i) {
    WriteWholeFile((folder / ("seed_" + std::to_string(i))).string(), seeds[i]);
  }
}

void RunMutations(size_t count) {
  const std::vector<std::string> seeds = Seeds();
  Require(!seeds.empty(), "the target has no seeds");
  for (const std::string& seed : seeds) Run(seed);
  Mutator mutator(seeds);
  for (size_t i = 0; i < count; ++i) Run(mutator.Next());
  std::printf("%zu seeds, %zu mutations\n", seeds.size(), count);
}

int Main(const std::vector<std::string>& arguments) {
  if (arguments.size() == 2 && arguments[0] == "--seeds") {
    WriteSeeds(arguments[1]);
  } else if (arguments.size() == 1 &&
             arguments[0].find_first_not_of("0123456789") == std::string::npos) {
    RunMutations(std::stoul(arguments[0]));
  } else {
    for (const std::string& path : arguments) Run(ReadText(path, kMaxInput));
  }
  return 0;
}

}  // namespace
}  // namespace topotag::fuzz

int main(int argc, char** argv) {
  try {
    return topotag::fuzz::Main({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
