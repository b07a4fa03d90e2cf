// The limit refuses before it is passed and says who holds what. Misses: sizes that nobody charges, which only the
// tests of the program see.
#include "base/memory.h"

#include <gtest/gtest.h>

#include <memory>

namespace kinora {
namespace {

struct Limit {
  explicit Limit(uint64_t bytes) { Memory::setLimit(bytes); }
  ~Limit() { Memory::setLimit(0); }
};

TEST(Memory, RefusesWhatDoesNotFitAndNamesTheLargest) {
  const Limit limit(Memory::resident() + (100 << 20));
  MemoryHold meshes(MemoryUse::Meshes), film(MemoryUse::Film);
  meshes.add(60 << 20);
  film.add(20 << 20);
  try {
    film.add(30 << 20);
    FAIL() << "30 MiB more than the limit were granted";
  } catch (const MemoryExceeded& e) {
    const std::string text = e.what();
    EXPECT_NE(text.find("film would take 30 MiB more"), std::string::npos) << text;
    EXPECT_LT(text.find("meshes 60 MiB"), text.find("film 20 MiB")) << text;
  }
  EXPECT_EQ(film.bytes(), 20u << 20);
  meshes.set(10 << 20);
  EXPECT_NO_THROW(film.add(30 << 20));
  EXPECT_EQ(Memory::used(MemoryUse::Meshes), 10u << 20);
}

TEST(Memory, HoldsAreReturned) {
  const uint64_t before = Memory::used(MemoryUse::Textures);
  {
    MemoryHold h(MemoryUse::Textures);
    h.set(1000);
    h.set(400);
    EXPECT_EQ(Memory::used(MemoryUse::Textures), before + 400);
  }
  EXPECT_EQ(Memory::used(MemoryUse::Textures), before);
}

TEST(Memory, WhatNobodyChargesIsSeenInTheResidentSize) {
  const Limit limit(Memory::resident() + (32 << 20));
  EXPECT_NO_THROW(Memory::check(MemoryUse::Program));
  const size_t size = 64 << 20;
  const auto block = std::make_unique<char[]>(size);
  for (size_t i = 0; i < size; i += 512) static_cast<volatile char*>(block.get())[i] = 1;
  EXPECT_THROW(Memory::check(MemoryUse::Description), MemoryExceeded);
  EXPECT_FALSE(Memory::tryCharge(MemoryUse::Meshes, 8 << 20));
}

TEST(Memory, WithoutALimitEverythingFits) {
  EXPECT_TRUE(Memory::tryCharge(MemoryUse::Pictures, uint64_t(1) << 50));
  Memory::release(MemoryUse::Pictures, uint64_t(1) << 50);
}

}  // namespace
}  // namespace kinora
