#include <gmock/gmock.h>
#include <iostream>
#include "tests/contract/still/still_backends.h"
namespace wheatstone {
TEST(Try, Opens) {
  GphotoBackend b;
  SteadyClock c;
  auto t0 = c.now_ns();
  auto lap = [&](const char* w) { std::cout << w << " " << (c.now_ns() - t0) / 1000000 << " ms\n"; t0 = c.now_ns(); };
  b.camera(); lap("open");
  auto id = b.camera().identity();
  std::cout << id.model << "|" << id.serial << "|" << id.firmware << "|" << id.address << "\n";
  b.world().light.led_drive = 1;
  for (int i = 0; i < 3; ++i) {
    RawFrame f = b.camera().expose(Duration::of(1 / 250.0), c.in(Duration::of(5)));
    lap("expose");
    std::cout << f.mosaic.width() << " " << f.exposure.value() << " " << f.file_type << " " << f.file.size() << " " << f.camera_serial << "\n";
  }
  b.close(); lap("close");
}
TEST(Try, Cli) {
  GphotoBackend b;
  std::system("cd /tmp; timeout 20 gphoto2 --auto-detect; timeout 20 gphoto2 --get-config shutterspeed | head -8; timeout 20 gphoto2 --list-config; timeout 30 gphoto2 --set-config shutterspeed=1/125 --capture-image-and-download --force-overwrite");
}
}
