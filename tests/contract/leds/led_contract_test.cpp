// The contract of LED arrays on the twin and on E1.31.

#include "tests/contract/leds/led_contract.h"

namespace wheatstone {
namespace {

const LedMaker kMakers[] = {{"Twin", [] { return std::make_unique<TwinLedBackend>(); }},
                            {"E131", [] { return std::make_unique<E131Backend>(); }}};
INSTANTIATE_TEST_SUITE_P(Leds, LedContract, ::testing::ValuesIn(kMakers),
                         [](const auto& maker) { return std::string(maker.param.name); });

}  // namespace
}  // namespace wheatstone
