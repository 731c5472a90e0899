#include "hardware/transport/serial_port.h"

#include <gmock/gmock.h>

#include <fstream>
#include <thread>

#include "sim/wire/pty_peer.h"
#include "tests/contract/resources.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

/// Gives back what it gets.
class Echo final : public SerialFirmware {
 public:
  void receive(std::string_view bytes, Nanoseconds) override { out_ += bytes; }
  std::string run(Nanoseconds) override { return std::exchange(out_, {}); }
  Nanoseconds next_event() const override { return kNever; }

 private:
  std::string out_;
};

class SerialPortTest : public ::testing::Test {
 protected:
  Deadline in(double seconds) { return clock_.in(Duration::of(seconds)); }
  std::unique_ptr<SerialPort> open(int baud = 115200) {
    return std::make_unique<SerialPort>("the echo", peer_.path(), baud);
  }
  template <class Call>
  Kind kind_of(const Call& call) {
    try {
      call();
    } catch (const DeviceError& e) {
      return e.kind();
    }
    ADD_FAILURE() << "no error";
    return Kind::kFault;
  }

  ResourceWatch resources_;
  SteadyClock clock_;
  Echo echo_;
  PtyPeer peer_{echo_};
};

TEST_F(SerialPortTest, CarriesEveryByteAtEverySpeed) {
  std::string all;
  for (int i = 0; i < 256; ++i) all += static_cast<char>(i);
  for (const int baud : {9600, 38400, 115200, 921600}) {
    const auto port = open(baud);
    port->write(all, in(5));
    std::string back;
    while (back.size() < all.size()) back += port->read(in(5));
    EXPECT_EQ(back, all);
    EXPECT_EQ(peer_.baud(), baud) << "as the other side sees it";
  }
  EXPECT_THROW(open(12345), ArgumentError);
}

TEST_F(SerialPortTest, SplitsLines) {
  const auto port = open();
  port->write("one\ntwo\nthr", in(5));
  EXPECT_EQ(port->read_line('\n', 10, in(5)), "one");
  EXPECT_EQ(port->read_line('\n', 10, in(5)), "two");
  EXPECT_EQ(port->try_read_line('\n', 10, in(0.05)), std::nullopt);
  port->write("ee\n", in(5));
  EXPECT_EQ(port->read_line('\n', 10, in(5)), "three");
  port->write(std::string(11, 'x'), in(5));
  EXPECT_EQ(kind_of([&] { port->read_line('\n', 10, in(5)); }), Kind::kProtocol);
  port->write("left over", in(5));
  port->write("!\n", in(5));
  while (!port->try_read_line('!', 100, in(5))) {
  }
  port->discard_input();
  EXPECT_EQ(port->try_read_line('\n', 10, in(0.02)), std::nullopt);
}

TEST_F(SerialPortTest, KeepsItsDeadline) {
  const auto port = open();
  for (const double s : {0.0, 0.05, 0.2}) {
    const Nanoseconds start = clock_.now_ns();
    EXPECT_EQ(kind_of([&] { port->read(in(s)); }), Kind::kTimeout);
    const double took = static_cast<double>(clock_.now_ns() - start) * 1e-9;
    EXPECT_GE(took, s - 0.001);
    EXPECT_LE(took, s + 0.1);
  }
}

TEST_F(SerialPortTest, StopsOnRequest) {
  const auto port = open();
  std::stop_source source;
  const std::jthread canceller([&] { source.request_stop(); });
  EXPECT_THROW(port->read(clock_.in(Duration::of(30), source.get_token())), Cancelled);
}

TEST_F(SerialPortTest, HasTheLineForItself) {
  const auto port = open();
  EXPECT_EQ(kind_of([&] { open(); }), Kind::kBusy);
}

TEST_F(SerialPortTest, StaysDisconnected) {
  const auto port = open();
  peer_.unplug();
  EXPECT_EQ(kind_of([&] { port->read(in(5)); }), Kind::kDisconnected);
  EXPECT_EQ(kind_of([&] { port->write("x", in(5)); }), Kind::kDisconnected);
  peer_.plug_in();
  EXPECT_EQ(kind_of([&] { port->read(in(5)); }), Kind::kDisconnected) << "until it is opened anew";
  const auto again = open();
  again->write("x", in(5));
  EXPECT_EQ(again->read(in(5)), "x");
}

TEST_F(SerialPortTest, NamesWhatIsNotThere) {
  EXPECT_EQ(kind_of([] { SerialPort("it", "/nonexistent/tty", 9600); }), Kind::kNotFound);
}

TEST_F(SerialPortTest, WritesATranscript) {
  const TemporaryFolder folder;
  const auto file = folder.path / "wire.jsonl";
  {
    SerialPort port("the echo", peer_.path(), 9600, std::make_shared<Transcript>(file));
    port.write("a\xff", in(5));
    port.read_line('\xff', 5, in(5));
  }
  const auto entries = read_transcript(file);
  ASSERT_GE(entries.size(), 2U);
  EXPECT_TRUE(entries[0].to_device);
  EXPECT_EQ(entries[0].bytes, "a\xff");
  EXPECT_FALSE(entries.back().to_device);
}

TEST(PtyPeer, FollowsItsLinkToAnotherTerminal) {
  const TemporaryFolder folder;
  Echo echo;
  PtyPeer peer(echo, folder.path / "device");
  EXPECT_EQ(peer.path(), folder.path / "device");
  const auto first = std::filesystem::read_symlink(peer.path());
  SerialPort keeps_the_old_one("it", peer.path(), 9600);
  peer.unplug();
  EXPECT_FALSE(std::filesystem::exists(folder.path / "device"));
  peer.plug_in();
  EXPECT_NE(std::filesystem::read_symlink(peer.path()), first);
  std::ofstream(folder.path / "file") << "x";
  EXPECT_THROW(PtyPeer(echo, folder.path / "file"), FileError);
}

}  // namespace
}  // namespace wheatstone
