// Looks for the orders of src/sampling/matched_orders.cpp, as that file has them.
#pragma once

namespace kinora::bench {

// Prints them; 1 where the source has others. isQuick: few trials, which find others, to test the program.
int printMatchedOrders(bool isQuick);

}  // namespace kinora::bench
