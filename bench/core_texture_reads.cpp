// texture_reads_*: tiles a second that threads read when their groups of lookups lack 32 each, of two tiled files that
// are made to answer late, as disks and networks do; gathered as renders do, and as each lookup comes. And what a thread
// whose tiles are in the cache notices of it. Waits are slept, so that more threads than cores mean something.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "core.h"
#include "texture/texture_system.h"

namespace kinora::bench {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kPointsOfGroup = 256;  // of a group
constexpr int kTilesOfGroup = 32;         // four rows of eight
constexpr int kTileSide = 64;

struct TileGroup {
  std::vector<float> s, t, radius, out[4];
  int32_t handle = TextureSystem::kNoTexture;

  // Points in the middles of its tiles, in an order that goes from tile to tile.
  TileGroup(int index, int side, int32_t file) : handle(file) {
    const int columns = side / kTileSide, across = columns / 8;
    for (uint32_t i = 0; i < kPointsOfGroup; ++i) {
      const int tile = int(i * 13u % uint32_t(kTilesOfGroup));
      const int x = index % across * 8 + tile % 8, y = index / across * 4 + tile / 8;
      s.push_back((float(x) + 0.3f + 0.4f * float(i) / float(kPointsOfGroup)) / float(columns));
      t.push_back((float(y) + 0.5f) / float(columns));
      radius.push_back(0);
    }
    for (auto& o : out) o.resize(kPointsOfGroup);
  }
  void look(TextureSystem& system) {
    float* const rgba[4] = {out[0].data(), out[1].data(), out[2].data(), out[3].data()};
    system.lookup(&handle, false, kPointsOfGroup, s.data(), t.data(), radius.data(), {}, rgba);
  }
};

std::vector<TileGroup> groupsOf(TextureSystem& system, const std::vector<std::string>& files, int side) {
  std::vector<TileGroup> groups;
  const int count = side / kTileSide * (side / kTileSide) / kTilesOfGroup;
  for (int g = 0; g < count; ++g)
    for (const std::string& file : files) groups.emplace_back(g, side, system.handle(file, {}));
  return groups;
}

void lookAtAll(TextureSystem& system, std::vector<TileGroup>& groups, int threads) {
  std::atomic<size_t> next{0};
  std::vector<std::thread> running;
  for (int k = 0; k < threads; ++k)
    running.emplace_back([&] {
      for (size_t g = next++; g < groups.size(); g = next++) groups[g].look(system);
    });
  for (std::thread& t : running) t.join();
}

}  // namespace

void measureTextureReads(const Options& options, Figures& figures) {
  const int side = options.quick ? 512 : 1024;
  const std::string file = makeTexture(side, false);
  if (file.empty()) {
    std::fprintf(stderr, "kinora-bench: error BENCH-WRITE: no temporary texture can be written\n");
    return;
  }
  const std::vector<std::string> files = {file, file + "2.tx"};
  fs::copy_file(files[0], files[1], fs::copy_options::overwrite_existing);
  const auto tilesPerSecond = [&](TextureReading reading, int threads) {
    Diagnostics diagnostics;
    TextureSystem system(diagnostics);
    system.setReading(reading);
    std::vector<TileGroup> groups = groupsOf(system, files, side);
    const uint64_t before = system.statistics().tilesRead;
    const double start = wallSeconds();
    lookAtAll(system, groups, threads);
    return double(system.statistics().tilesRead - before) / (wallSeconds() - start);
  };
  const std::vector<int> delays = options.quick ? std::vector{1} : std::vector{0, 1, 10};
  for (const int ms : delays)
    for (const int threads : {1, 2, 4, 8}) {
      std::vector<double> rate, gain;
      for (int i = 0; i < options.repeat; ++i) {
        const uint32_t delay = uint32_t(ms) * 1000;
        const double single = tilesPerSecond({TextureReading::OneByOne, delay}, threads);
        rate.push_back(tilesPerSecond({TextureReading::Measured, delay}, threads));
        gain.push_back(rate.back() / single);
      }
      const std::string name = std::to_string(ms) + "ms_" + std::to_string(threads);
      figures.add("texture_reads_" + name, rate, "tiles a second, cold; files answer so much later; threads");
      figures.add("texture_reads_gain_" + name, gain, "over those when each lookup reads by itself");
    }

  // four threads wait for files all the while
  std::vector<double> beside;
  for (int i = 0; i < options.repeat; ++i) {
    Diagnostics diagnostics;
    TextureSystem system(diagnostics);
    std::vector<TileGroup> groups = groupsOf(system, files, side);
    TileGroup mine = groups[0];
    mine.look(system);
    const int rounds = options.quick ? 20 : 2000;
    const auto seconds = [&] {
      const double start = wallSeconds();
      for (int k = 0; k < rounds; ++k) mine.look(system);
      return wallSeconds() - start;
    };
    const double alone = seconds();
    system.setReading({TextureReading::OneByOne, 10'000});
    std::thread readers([&] { lookAtAll(system, groups, 4); });
    beside.push_back(alone / seconds());
    readers.join();
  }
  figures.add("texture_hits_beside_reads", beside,
              "lookups a second in cache while four threads wait 10 ms for each tile, over those alone");
  for (const std::string& one : files) fs::remove(one);
}

}  // namespace kinora::bench
