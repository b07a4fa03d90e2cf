// Looks for the orders of src/sampling/matched_orders.cpp, as that file has them.
#pragma once

namespace kinora::bench {

// Prints them. isQuick: few trials, to test the program.
int printMatchedOrders(bool isQuick);

}  // namespace kinora::bench
