namespace shape::internal {
}
