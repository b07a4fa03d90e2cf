// Proves: bricks read the same wherever the store keeps them, by several threads at once; so much of its file is in memory as
// its bound says; a folder that holds no file is told and costs memory. Misses: full disks.
#include "volume/voxel_store.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <thread>

#include "volume/voxel_grid.h"

namespace kinora::volume {
namespace {

uint32_t hashed(uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

// 96 x 96 x 96 bricks of 2 KiB, a third of them there.
std::unique_ptr<VoxelGrid> largeGrid(std::shared_ptr<VoxelStore> store) {
  GridShape shape;
  for (int k = 0; k < 3; ++k) {
    shape.size[k] = 96 * 8;
    shape.worldToIndex[5 * k] = 1;
  }
  shape.worldToIndex[15] = 1;
  auto grid = std::make_unique<VoxelGrid>(shape, std::move(store));
  for (uint32_t b = 0; b < shape.brickCount(); b += 3) {
    float* const to = grid->addBrick(b);
    for (uint32_t i = 0; i < uint32_t(GridShape::kVoxels); ++i) to[i] = float(hashed(b * 512 + i) >> 8);
    grid->coarsen(b);
  }
  grid->coarsen(shape.brickCount());
  return grid;
}
// Of lookups at random places, and in a row.
double sumOf(const VoxelGrid& grid, uint32_t seed, uint32_t lookups) {
  double sum = 0;
  for (uint32_t i = 0; i < lookups; ++i) {
    double at[3];
    for (uint32_t k = 0; k < 3; ++k) at[k] = 767.0 * double(hashed(seed + 3 * i + k)) * 0x1p-32;
    for (int step = 0; step < 4; ++step) {
      float v = 0;
      grid.lookUp(at, {}, &v);
      sum += double(v);
      at[0] += 0.7;
    }
  }
  return sum;
}
// Of files that are mapped, bytes in memory.
uint64_t mappedBytes() {
  unsigned long long all = 0, resident = 0, shared = 0;
  std::FILE* const f = std::fopen("/proc/self/statm", "r");
  if (!f || std::fscanf(f, "%llu %llu %llu", &all, &resident, &shared) != 3) shared = 0;
  if (f) std::fclose(f);
  return shared * uint64_t(::sysconf(_SC_PAGESIZE));
}

TEST(VoxelStore, TheSameNumbersWithinABound) {
  constexpr uint64_t kBound = 128 << 20;
  constexpr uint32_t kThreads = 4, kLookups = 100000;
  const auto whole = largeGrid(nullptr);
  const auto store = std::make_shared<VoxelStore>(kBound);
  const uint64_t before = mappedBytes();
  const auto bounded = largeGrid(store);
  ASSERT_EQ(store->failure(), "");
  EXPECT_EQ(bounded->bytes(), whole->bytes());
  EXPECT_GT(bounded->bytes(), 4 * kBound);
  double sums[kThreads];
  uint64_t mapped[kThreads] = {};
  std::vector<std::thread> threads;
  for (uint32_t t = 0; t < kThreads; ++t)
    threads.emplace_back([&, t] {
      sums[t] = sumOf(*bounded, t * 77777, kLookups);
      mapped[t] = mappedBytes();
    });
  for (std::thread& t : threads) t.join();
  for (uint32_t t = 0; t < kThreads; ++t) {
    EXPECT_EQ(sums[t], sumOf(*whole, t * 77777, kLookups));
    EXPECT_LT(mapped[t], before + kBound * 5 / 4);
  }
  const VoxelStore::Counts c = store->counts();
  EXPECT_LE(c.memoryBytes, kBound / 2);
  EXPECT_GE(c.memoryBytes + c.fileBytes, bounded->bytes() - whole->shape().brickCount() * sizeof(float*));
  EXPECT_LE(c.mostBytes, kBound + kThreads * VoxelStore::kChunk);
  EXPECT_GT(c.wentOut, c.fileBytes / VoxelStore::kChunk) << "random places come back to what went";
  EXPECT_EQ(c.cameIn - c.wentOut <= kBound / VoxelStore::kChunk, true);
}

TEST(VoxelStore, KeepsLittleOfItsFileWhileItIsFilled) {
  const auto store = std::make_shared<VoxelStore>(uint64_t(512) << 20);
  {
    const VoxelStore::Filling filling(store);
    largeGrid(store);
  }
  const VoxelStore::Counts c = store->counts();
  EXPECT_GT(c.fileBytes, uint64_t(128) << 20);
  EXPECT_LE(c.mostBytes, c.memoryBytes + VoxelStore::kLeast + VoxelStore::kChunk);
}

TEST(VoxelStore, WithoutABoundAllIsInMemory) {
  VoxelStore store(0);
  for (int i = 0; i < 100; ++i) store.add(1 << 16)[0] = 1;
  EXPECT_EQ(store.counts().memoryBytes, 100u << 18);
  EXPECT_EQ(store.counts().fileBytes, 0u);
}

TEST(VoxelStore, WhatIsGivenBackIsUsedAgain) {
  for (const uint64_t bound : {uint64_t(0), uint64_t(2) << 20}) {
    VoxelStore store(bound);
    store.add(1 << 16)[0] = 1;
    const VoxelStore::Mark mark = store.mark();
    const VoxelStore::Counts before = store.counts();
    float* const first = store.add(1 << 18);
    for (int i = 0; i < 10; ++i) store.add(1 << 18)[0] = 1;
    store.release(mark);
    EXPECT_EQ(store.counts().memoryBytes, before.memoryBytes);
    EXPECT_EQ(store.counts().fileBytes, before.fileBytes);
    float* const again = store.add(1 << 18);
    if (bound) {
      EXPECT_EQ(again, first) << "of the file";
    }
  }
}

TEST(VoxelStore, AFolderWithoutRoomIsTold) {
  VoxelStore store(1 << 20, "/nowhere/at all");
  std::vector<float*> at;
  for (int i = 0; i < 20; ++i) {
    at.push_back(store.add(1 << 16));
    at.back()[(1 << 16) - 1] = float(i);
  }
  for (int i = 0; i < 20; ++i) EXPECT_EQ(at[size_t(i)][(1 << 16) - 1], float(i));
  EXPECT_NE(store.failure().find("/nowhere/at all"), std::string::npos) << store.failure();
  EXPECT_EQ(store.counts().memoryBytes, 20u << 18);
}

}  // namespace
}  // namespace kinora::volume
