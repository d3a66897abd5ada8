#!/bin/sh
# Installs header, libraries, pkg-config and CMake files, and the Fortran sources:
#
#     capi/install.sh PREFIX [BUILT]
#
#     PREFIX/include/diffuse_contact.h
#     PREFIX/lib/libdiffuse_contact.so -> .so.0.1 -> .so.0.1.0, libdiffuse_contact.a
#     PREFIX/lib/pkgconfig/diffuse_contact.pc
#     PREFIX/lib/cmake/diffuse_contact/diffuse_contact-config.cmake
#     PREFIX/share/diffuse_contact/diffuse_contact.f90, uel.f90, uel_domains.f90, write_uel.f90, examples/*.inp
#
# Builds the libraries with optimisation first, or takes them from the directory BUILT. With DESTDIR set, everything goes below it
# (for packagers). Needs Rust and a C linker; gcc or gfortran to use what it installs.
set -eu

if [ $# -lt 1 ] || [ $# -gt 2 ]; then
    sed -n '2,4s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
prefix=$1
here=$(cd "$(dirname "$0")" && pwd)
case $prefix in
/*) ;;
*) prefix=$(pwd)/$prefix ;;
esac

# Before minutes of building: a folder that may not be written ends the script here.
root=${DESTDIR:-}$prefix
mkdir -p "$root/include" "$root/lib/pkgconfig" "$root/lib/cmake/diffuse_contact" "$root/share/diffuse_contact/examples"

if [ $# = 2 ]; then
    built=$(cd "$2" && pwd)
else
    # Cargo says where it builds, which its configuration may set.
    library=$(cd "$here" && cargo build --release -p diffuse-contact-capi --message-format=json-render-diagnostics |
        grep -o '"[^"]*/libdiffuse_contact\.so"' | tail -n 1 | tr -d '"')
    if [ -z "$library" ]; then
        echo "install.sh: no libdiffuse_contact.so was built; on other systems than Linux take the library from Cargo" >&2
        exit 1
    fi
    built=$(dirname "$library")
fi

version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' "$here/../Cargo.toml")
case $version in
0.*) interface=$(echo "$version" | cut -d. -f1-2) ;;
*) interface=${version%%.*} ;;
esac

install -m 644 "$here/include/diffuse_contact.h" "$root/include/"
install -m 755 "$built/libdiffuse_contact.so" "$root/lib/libdiffuse_contact.so.$version"
ln -sf "libdiffuse_contact.so.$version" "$root/lib/libdiffuse_contact.so.$interface"
ln -sf "libdiffuse_contact.so.$interface" "$root/lib/libdiffuse_contact.so"
install -m 644 "$built/libdiffuse_contact.a" "$root/lib/"
sed -e "s|@PREFIX@|$prefix|" -e "s|@VERSION@|$version|" "$here/diffuse_contact.pc.in" \
    >"$root/lib/pkgconfig/diffuse_contact.pc"
private=$(sed -n 's/^Libs.private: //p' "$here/diffuse_contact.pc.in" | tr ' ' ';')
for file in diffuse_contact-config.cmake diffuse_contact-config-version.cmake; do
    sed -e "s|@VERSION@|$version|" -e "s|@INTERFACE@|$interface|" -e "s|@PRIVATE@|$private|" "$here/$file.in" \
        >"$root/lib/cmake/diffuse_contact/$file"
done
install -m 644 "$here/../fortran/diffuse_contact.f90" "$here/../fortran/uel.f90" \
    "$here/../fortran/uel_domains.f90" "$here/../fortran/write_uel.f90" "$root/share/diffuse_contact/"
install -m 644 "$here/../fortran/examples/block_on_cylinder.inp" \
    "$here/../fortran/examples/block_on_cylinder_friction.inp" "$root/share/diffuse_contact/examples/"
echo "installed $version in $root"
echo "for pkg-config and programs: export PKG_CONFIG_PATH=$prefix/lib/pkgconfig LD_LIBRARY_PATH=$prefix/lib"
