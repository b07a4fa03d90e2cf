// Proves: a grid comes whole out of the stream that another process writes; a stream that is cut short, goes on, is
// garbage or never ends, and a process that dies, cannot be started or does nothing, are each a reason in words and
// cost no more than their time. The processes are scripts here; tests/shaders starts the program itself.
#include "volume/read_process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <thread>

#include "volume/grid_stream.h"
#include "volume/volume_system.h"

namespace kinora::volume {
namespace {

// 8 x 6 x 4 voxels, "density" = x + 10 y + 100 z and "Cd" = (x, y, z); a voxel is 0.5 wide, the first lies at (1, 2,
// 3). Made with OpenVDB 10: FloatGrid and Vec3SGrid with createLinearTransform(), setValue() of each voxel, io::File
// with COMPRESS_ZIP | COMPRESS_ACTIVE_MASK.
const std::string kVolumes = KINORA_SOURCE_DIR "/tests/shaders/volumes.vdb";

class ReadProcess : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = testing::TempDir() + "kinora_volume_XXXXXX";
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  // What the process writes for a grid. The file is a good one: this process reads it.
  std::string streamOf(const std::string& which) {
    const std::string path = folder_ + "/stream";
    const int to = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    EXPECT_TRUE(sendGrid(kVolumes, which, to));
    close(to);
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  // A reader that runs a script; its words are FILE, GRID, BYTES, SECONDS.
  ReaderProgram script(const std::string& text, double seconds = 20) {
    std::ofstream(folder_ + "/script") << text << '\n';
    return {{"/bin/sh", folder_ + "/script"}, seconds};
  }
  ReaderProgram giving(const std::string& stream) {
    std::ofstream(folder_ + "/given", std::ios::binary) << stream;
    return script("exec cat '" + folder_ + "/given'");
  }
  std::string errorOf(const ReaderProgram& program) {
    std::string error;
    EXPECT_EQ(readGrid(program, kVolumes, "", error), nullptr);
    EXPECT_FALSE(error.empty());
    return error;
  }
  static float value(const VoxelGrid& grid, double x, double y, double z, int channel = 0) {
    const double index[3] = {x, y, z};
    float v[3];
    grid.lookUp(index, {}, v);
    return v[channel];
  }
  static std::string received(const std::string& stream, std::unique_ptr<VoxelGrid>& grid,
                              uint64_t most = uint64_t(1) << 30) {
    size_t at = 0;
    std::string error;
    grid = receiveGrid(
        [&](void* to, size_t bytes) {
          if (stream.size() - at < bytes) return at = stream.size(), false;
          std::memcpy(to, stream.data() + at, bytes);
          at += bytes;
          return true;
        },
        most, error);
    return error;
  }
  std::string folder_;
};

TEST_F(ReadProcess, AGridComesWhole) {
  std::string error;
  const auto density = readGrid(giving(streamOf("")), kVolumes, "", error);
  ASSERT_NE(density, nullptr) << error;
  EXPECT_EQ(density->shape().subimage, 1);
  EXPECT_EQ(density->shape().channels, 1);
  EXPECT_EQ(density->shape().size[0], 8);
  EXPECT_EQ(density->shape().size[1], 6);
  EXPECT_EQ(density->shape().size[2], 4);
  EXPECT_EQ(density->shape().worldToIndex[0], 2);
  EXPECT_EQ(density->shape().worldToIndex[13], -4);
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 8; ++x) EXPECT_EQ(value(*density, x, y, z), float(x + 10 * y + 100 * z));
  for (const char* which : {"=Cd", "#0"}) {
    const auto colour = readGrid(giving(streamOf(which)), kVolumes, which, error);
    ASSERT_NE(colour, nullptr) << error;
    EXPECT_EQ(colour->shape().channels, 3);
    EXPECT_EQ(value(*colour, 2.5, 1.25, 3, 0), 2.5f);
    EXPECT_EQ(value(*colour, 2.5, 1.25, 3, 1), 1.25f);
    EXPECT_EQ(value(*colour, 2.5, 1.25, 3, 2), 3.f);
  }
  const auto turned = readGrid(giving(streamOf("=turned")), kVolumes, "=turned", error);
  ASSERT_NE(turned, nullptr) << error;
  EXPECT_EQ(value(*turned, -2, -3, -5), 7.f);
  EXPECT_EQ(value(*turned, -43, -3, -5), 3.f);
  EXPECT_EQ(value(*turned, -30.5, -12, -9), 2.f);
  EXPECT_EQ(value(*turned, -40.5, -12, -12.25), 1.f);
  EXPECT_EQ(value(*turned, -20, -3, -5), 0.f);
  const float world[3] = {1 - 0.5f * -3, 2 + 0.5f * -43, 3 + 0.5f * -5};
  double index[3];
  turned->toIndex(world, index);
  EXPECT_EQ(index[0], -43);
  EXPECT_EQ(index[1], -3);
  EXPECT_EQ(index[2], -5);
  EXPECT_EQ(errorOf(giving(streamOf("=fuel"))), "it has no grid 'fuel'; it holds 'Cd', 'density', 'turned'");
  EXPECT_EQ(errorOf(giving(streamOf("#3"))), "it has no grid number 3; it holds 'Cd', 'density', 'turned'");
}

TEST_F(ReadProcess, StreamsThatAreNotBelieved) {
  const std::string good = streamOf("");
  std::unique_ptr<VoxelGrid> grid;
  EXPECT_EQ(received(good, grid), "");
  ASSERT_NE(grid, nullptr);
  for (size_t length = 0; length < good.size(); ++length) {
    EXPECT_EQ(received(good.substr(0, length), grid), "") << length;  // too early: the process knows why
    EXPECT_EQ(grid, nullptr) << length;
  }
  EXPECT_NE(received(good + "x", grid), "");
  EXPECT_EQ(grid, nullptr);
  EXPECT_NE(received(good + good, grid), "");
  EXPECT_EQ(grid, nullptr);
  // records: shape (8 + 160 bytes), a brick, the end
  const auto with = [&](size_t at, uint32_t word) {
    std::string bytes = good;
    std::memcpy(bytes.data() + at, &word, 4);
    return bytes;
  };
  const size_t brick = 8 + sizeof(GridShape);
  for (const auto& [at, word] : {std::pair<size_t, uint32_t>{0, 2},
                                 {0, 77},
                                 {4, 8},
                                 {12, 2},
                                 {28, 0x7fffffff},
                                 {brick, 9},
                                 {brick, 4},
                                 {brick + 4, 1},
                                 {brick + 4, 0xffffffff},
                                 {good.size() - 4, 2}}) {
    EXPECT_NE(received(with(at, word), grid), "") << at << ' ' << word;
    EXPECT_EQ(grid, nullptr) << at << ' ' << word;
  }
  // more memory than is granted
  EXPECT_NE(received(good, grid, 1).find("take more memory"), std::string::npos);
  // a reason with anything in it
  const uint32_t refusal[2] = {uint32_t(GridRecord::Refusal), 1000};
  std::string told(reinterpret_cast<const char*>(refusal), sizeof refusal);
  told += "no \n\x1b[2J\xff" + std::string(1000 - 9, '\0');
  EXPECT_EQ(received(told, grid).substr(0, 10), "no ??[2J??");
  EXPECT_EQ(received(told, grid).size(), 300u);
  // the same brick twice
  const std::string one = good.substr(brick, good.size() - 8 - brick);
  EXPECT_NE(received(good.substr(0, good.size() - 8) + one + good.substr(good.size() - 8), grid), "");
  EXPECT_EQ(grid, nullptr);
  std::mt19937 random(7);
  for (int k = 0; k < 2000; ++k) {
    std::string bytes = good;
    for (int n = 0; n < 4; ++n) bytes[random() % (k % 2 ? 200 : bytes.size())] = char(random());
    received(bytes, grid);
    if (grid) value(*grid, 3, 2, 1);
  }
}

TEST_F(ReadProcess, ProcessesThatFail) {
  EXPECT_NE(errorOf(script("exit 3")).find("ended with exit code 3"), std::string::npos);
  EXPECT_NE(errorOf(script("kill -ABRT $$")).find("ended with signal 6 (Aborted)"), std::string::npos);
  EXPECT_NE(errorOf(script("kill -XCPU $$")).find("took too long"), std::string::npos);
  EXPECT_NE(errorOf(script("echo garbage and more of it; exec sleep 100")), "");
  EXPECT_NE(errorOf(script("echo garbage >&2")), "");  // to nobody
  EXPECT_NE(errorOf(giving(streamOf("").substr(0, 1000))).find("exit code 0"), std::string::npos);
  EXPECT_NE(errorOf({{"/nothing/there"}, 5}).find("/nothing/there: No such file"), std::string::npos);
  EXPECT_NE(errorOf({}), "");
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(errorOf(script("exec sleep 1000", 0.5)), "it was not read within 1 seconds");
  EXPECT_EQ(errorOf(script("exec cat /dev/zero", 0.5)), "what came of it cannot be understood");
  const auto seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_LT(seconds, 60);
  // a grandchild that keeps the pipe open
  EXPECT_NE(errorOf(script("sleep 5 & exit 4", 0.5)), "");
}

TEST_F(ReadProcess, TheSystemReadsOnceAndTellsOnce) {
  std::vector<std::string> lines;
  std::mutex mutex;
  Diagnostics diagnostics([&](const std::string& line, Severity) {
    const std::lock_guard lock(mutex);
    lines.push_back(line);
  });
  streamOf("");
  VolumeSystem system(diagnostics, script("echo x >> '" + folder_ + "/count'; exec cat '" + folder_ + "/stream'"));
  system.setSearchPath({folder_, KINORA_SOURCE_DIR "/tests/shaders"});
  std::vector<const VoxelGrid*> found(8);
  {
    std::vector<std::jthread> threads;
    for (auto& to : found) threads.emplace_back([&] { to = system.grid("volumes.vdb", "", "a test"); });
  }
  for (const VoxelGrid* grid : found) EXPECT_EQ(grid, found[0]);
  ASSERT_NE(found[0], nullptr);
  EXPECT_EQ(std::filesystem::file_size(folder_ + "/count"), 2u);
  EXPECT_EQ(system.grid("volumes.vdb", "#1", "a test"), found[0]);  // the same grid is held once
  EXPECT_EQ(system.find("volumes.vdb"), KINORA_SOURCE_DIR "/tests/shaders/volumes.vdb");
  EXPECT_TRUE(lines.empty());
  EXPECT_EQ(system.find("script"), "");
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(system.grid("lost.vdb", "", "a test"), nullptr);
    EXPECT_EQ(system.grid("script", "", "a test"), nullptr);
    EXPECT_EQ(system.grid("", "", "a test"), nullptr);
  }
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NE(lines[0].find("ASSET-VOLUME-MISSING: volume 'lost.vdb' of a test is not there"), std::string::npos)
      << lines[0];
  EXPECT_NE(lines[1].find("ASSET-VOLUME-READ"), std::string::npos) << lines[1];
  EXPECT_NE(system.grid("/elsewhere/volumes.vdb", "", "a test"), nullptr);
  EXPECT_EQ(diagnostics.count("ASSET-VOLUME-MISSING"), 2u);
}

}  // namespace
}  // namespace kinora::volume
