# `cmake --install` and a Debian package: programs in libexec, one script in bin, data in share.
install(PROGRAMS fusion-slam DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY config DESTINATION ${CMAKE_INSTALL_DATADIR}/fusion-slam)
install(DIRECTORY lcmtypes DESTINATION ${CMAKE_INSTALL_DATADIR}/fusion-slam FILES_MATCHING PATTERN "*.lcm")
install(FILES README.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "the Fusion-SLAM authors <fusion-slam@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "liblcm-bin, iproute2")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
include(CPack)
