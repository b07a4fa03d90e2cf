#include "base/arena.h"

#include <gtest/gtest.h>

#include <array>

namespace kinora {
namespace {

using Numbers = std::array<int, 40>;

TEST(Arena, PutsBackWhatWasKeptForAMark) {
  Arena arena;
  int* older = arena.make<int>(1);
  *older = 1;
  const uint64_t born = arena.now();
  EXPECT_EQ(arena.newestMark(), 0u);
  const Arena::Mark outer = arena.mark();
  EXPECT_GT(arena.newestMark(), born);
  arena.keepUntilRelease(older, sizeof *older, born);
  *older = 2;
  arena.make<Numbers>(1);
  const Arena::Mark inner = arena.mark();
  EXPECT_FALSE(inner < outer);
  arena.keepUntilRelease(older, sizeof *older, born);
  *older = 3;
  // of the inner mark's memory, born behind the outer mark: nothing is written there once that is released
  int* young = arena.make<int>(1);
  *young = 10;
  arena.keepUntilRelease(young, sizeof *young, arena.now());
  *young = 11;
  arena.release(inner);
  EXPECT_EQ(*older, 2);
  EXPECT_EQ(*young, 11);
  arena.keepUntilRelease(older, sizeof *older, born);
  *older = 4;
  arena.release(outer);
  EXPECT_EQ(*older, 1);
  *older = 5;
  arena.release(outer);
  EXPECT_EQ(*older, 5);  // nothing was kept since
}

TEST(Arena, MarksAtOnePlaceEndOneByOne) {
  Arena arena;
  arena.make<int>(1);
  const Arena::Mark outer = arena.mark();
  const uint64_t made = arena.newestMark();
  { const ArenaScope scope(arena); }
  EXPECT_EQ(arena.newestMark(), made);
  {
    const ArenaScope scope(arena);
    arena.make<Numbers>(1);
    const ArenaScope within(arena);
    EXPECT_GT(arena.newestMark(), made);
  }
  EXPECT_EQ(arena.newestMark(), made);
  arena.end(outer);
  EXPECT_EQ(arena.newestMark(), 0u);
}

}  // namespace
}  // namespace kinora
