// Proves that programs of the group machine give what their text says, at every width, block and number of points
// with the same bits. Expected values are computed here, point by point. It misses the front end: programs are .oso
// text.
#include "language/vm/test_runner.h"

namespace kinora::language {
namespace {
using namespace testing;

TEST(Machine, ArithmeticOnNumbersAndTriples) {
  const Answer a = runEverywhere(groupOf(R"(OpenShadingLanguage 1.00
shader test
param	float	scale	2.5
oparam	float	sum	0
oparam	color	mixed	0 0 0
global	float	u
global	float	v
global	point	P
temp	float	$t1
temp	vector	$t2
const	float	$c1	0.5
code ___main___
	mul	$t1 u scale
	add	sum $t1 v
	mul	$t2 P $c1
	sub	$t2 $t2 sum
	add	mixed $t2 $t2
	end
)",
                                         {"sum", "mixed"}));
  for (uint32_t i = 0; i < 300; ++i) {
    const float u = Points::uOf(i), v = Points::vOf(i), sum = u * 2.5f + v;
    EXPECT_EQ(a.of("sum", i), sum);
    const float x = (3 * u - 1) * 0.5f - sum;
    EXPECT_EQ(a.of("mixed.0", i), x + x);
  }
}

TEST(Machine, BranchesLoopsAndEarlyEnds) {
  const Answer a = runEverywhere(groupOf(R"(OpenShadingLanguage 1.00
shader test
oparam	float	r	0
oparam	int	turns	0
global	float	u
global	float	v
local	int	i
local	float	x
temp	int	$t1
temp	int	$t2
temp	int	$t3
const	float	$half	0.5
const	float	$limit	3
const	int	$zero	0
const	int	$one	1
const	int	$ten	10
const	int	$three	3
const	float	$two	2
const	string	$f	"f"
code ___main___
	assign	x u
	for	$t1 3 4 14 15
	assign	i $zero
	lt	$t1 i $ten
	add	x x v
	eq	$t2 i $three
	if	$t2 7 7
	gt	$t2 x $limit
	if	$t2 10 10
	break
	add	turns turns $one
	lt	$t3 x $half
	if	$t3 14 14
	continue
	add	i i $one
	mul	r x $two
	functioncall	$f 22
	gt	$t2 u $half
	if	$t2 21 21
	add	r r $one
	return
	add	r r $ten
	end
)",
                                         {"r", "turns"}));
  for (uint32_t k = 0; k < 300; ++k) {
    const float u = Points::uOf(k), v = Points::vOf(k);
    float x = u;
    int turns = 0;
    for (int i = 0; i < 10; ++i) {
      x += v;
      if (x > 3) break;
      ++turns;
    }
    float r = x * 2;
    r += u > 0.5f ? 1.f : 10.f;
    EXPECT_EQ(a.intOf("turns", k), turns) << k;
    EXPECT_EQ(a.of("r", k), r) << k;
  }
}

}  // namespace
}  // namespace kinora::language
