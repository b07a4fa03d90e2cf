// The tables that draw2() reads: 16 sets of 1,024 two-dimensional samples, each stratified in every elementary base-2
// interval for every prefix of 2^k samples (a randomised (0,2)-sequence, which is what PMJ02 means). Built at first
// use, deterministic, thread-safe. Called by render/ when a world is made; addresses and hashes are in
// kinora/random.h.
#pragma once
#include <kinora/sample_table.h>

namespace kinora {

// Progressive multi-jittered (0,2) samples, generated stochastically: each new sample goes where the prefix leaves a
// stratum empty, at random within it. Dimensions are shuffled against each other by chance.
const SampleTable& pmj02Table();
// The first two Sobol' dimensions with Owen's nested uniform scrambling, other random numbers for each set, and orders
// that stratify a camera path's first dimensions with each other (matched_orders.h). What frames are rendered with.
const SampleTable& sobolTable();

}  // namespace kinora
